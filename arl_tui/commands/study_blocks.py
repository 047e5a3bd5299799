"""What the steps of a study that play games mean: sessions, practice and calibrations as `arl` runs them."""

from collections.abc import Callable
from pathlib import Path
from typing import assert_never

from arl_tui.games.registry import words_of
from arl_tui.study.run import BlockCall, Played
from studies.lab.config import Block, Calibration, Practice
from studies.lab.read import LoadedStudy


def player(loaded: LoadedStudy, home: Path) -> Callable[[BlockCall], Played]:
    """Return what runs the steps of a study that play games, in this terminal."""

    def play(call: BlockCall) -> Played:
        match call.step:
            case Block():
                return _play_block(loaded, call, home)
            case Practice() | Calibration():
                raise NotImplementedError
            case other:
                assert_never(other)

    return play


def _play_block(loaded: LoadedStudy, call: BlockCall, home: Path) -> Played:
    from arl_tui.commands.play import run_live

    assert isinstance(call.step, Block), "a block"
    protocol = loaded.block_protocol(call.condition, call.step)
    outcome = run_live(
        protocol,
        participant=call.code,
        seed=call.seed,
        recordings=call.folder,
        source={f"study.{name}": value for name, value in call.facts.items()},
    )
    tally = outcome.tally
    games = tuple(tally.performances)
    words = words_of(protocol.game)
    finished = outcome.trouble is None and len(games) == protocol.session.episodes
    return Played(
        how="finished" if finished else "failed" if outcome.trouble else "stopped",
        file=outcome.recording.name if outcome.recording else "",
        games=games,
        presses=tally.good + tally.bad - tally.taken_back,
        unit=words.units[1],
        trouble=outcome.trouble or "",
    )
