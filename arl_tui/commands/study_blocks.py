"""What the steps of a study that play games mean: sessions, practice and calibrations as `arl` runs them."""

import contextlib
import io
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, assert_never

import click

from arl_tui.games.registry import words_of
from arl_tui.study.calibrations import calibration_configs
from arl_tui.study.presenter import BlockCall, How, Played
from core.recording.reader import RecordingError
from core.session.protocol import Protocol
from studies.lab.config import Block, Calibration, Practice
from studies.lab.read import LoadedStudy

if TYPE_CHECKING:
    from arl_tui.app.outcome import SessionOutcome
    from core.recording.joined import FinishedPart


def player(loaded: LoadedStudy) -> Callable[[BlockCall], Played]:
    """Return what runs the steps of a study that play games, in this terminal."""

    def play(call: BlockCall) -> Played:
        # What is said to the experimenter must not stand on the participant's screen between two pages.
        said = io.StringIO()
        try:
            with contextlib.redirect_stderr(said):
                played = _play(loaded, call)
        except click.ClickException as error:
            return Played(how="failed", trouble=error.format_message())
        except (RecordingError, OSError) as error:
            return Played(how="failed", trouble=str(error))
        return _with_remark(played, said.getvalue().strip())

    return play


def _with_remark(played: Played, said: str) -> Played:
    """Return what is left of a step, with what the experimenter is told."""
    return replace(played, remark="\n".join(part for part in (played.remark, said) if part))


def _play(loaded: LoadedStudy, call: BlockCall) -> Played:
    match call.step:
        case Block():
            return _play_block(loaded, call, call.step)
        case Practice():
            return _play_practice(loaded, call, call.step)
        case Calibration():
            return _calibrate(loaded, call, call.step)
        case other:
            assert_never(other)


def _play_block(loaded: LoadedStudy, call: BlockCall, step: Block) -> Played:
    if call.resume is not None:
        return _go_on(call, call.resume)
    from arl_tui.commands.credit import settle_credit

    as_written = loaded.block_protocol(call.condition, step)
    # The participant's own folder holds their calibrations, as the folder of recordings does for `arl play`.
    protocol, source = settle_credit(as_written, None, call.folder, call.code)
    return _session(protocol, call, source)


def settle_simulated(loaded: LoadedStudy) -> Callable[[BlockCall, Block], tuple[Protocol, dict[str, str]]]:
    """Return what settles the credit rule of a simulated participant's block.

    It is the rule of a participant where there is a calibration. Where there is none, a simulated
    participant's own delay is known all the same.
    """

    def settle(call: BlockCall, step: Block) -> tuple[Protocol, dict[str, str]]:
        from arl_tui.commands.credit import settle_credit
        from arl_tui.participants import read_delays

        protocol = loaded.block_protocol(call.condition, step)
        if protocol.delay_of in ("rule", "paper") or read_delays(call.folder, call.code) is not None:
            return settle_credit(protocol, None, call.folder, call.code)
        return loaded.simulated_protocol(call.condition, step), {}

    return settle


def _go_on(call: BlockCall, path: Path) -> Played:
    """Go on with a block that broke off: its protocol and its credit rule are those of the file."""
    from arl_tui.commands.exact import protocol_of
    from arl_tui.commands.resume import credit_facts, part_to_go_on_with

    recording, kept = part_to_go_on_with(path)
    return _session(protocol_of(recording), call, credit_facts(recording), kept=kept)


def _play_practice(loaded: LoadedStudy, call: BlockCall, step: Practice) -> Played:
    return _session(loaded.practice_protocol(step), call, {}, practice=True)


def _session(
    protocol: Protocol,
    call: BlockCall,
    source: dict[str, str],
    *,
    kept: "FinishedPart | None" = None,
    practice: bool = False,
) -> Played:
    from arl_tui.commands.play import live_app

    app, outcome = live_app(
        protocol,
        participant=call.code,
        seed=call.seed,
        recordings=call.folder,
        source=source,
        study=call.facts,
        kept=kept,
        practice=practice,
        part=call.part,
        on_gone=call.on_gone,
    )
    if outcome is None:
        return Played(
            how="window-closed" if app.ended_by is not None else "failed", trouble="the app ended early"
        )
    tally = outcome.tally
    games = tuple(tally.performances)
    words = words_of(protocol.game)
    return Played(
        how=_how(outcome, gone=app.ended_by is not None),
        file=outcome.recording.name if outcome.recording else "",
        games=games,
        presses=tally.good + tally.bad,
        taken_back=tally.taken_back,
        unit=words.unit,
        trouble=outcome.trouble or "",
        remark=outcome.warning,
    )


def _how(outcome: "SessionOutcome", *, gone: bool) -> How:
    """Return how a block or a practice ended.

    Its tally holds games also where it was left before it began: those of the part that broke off.
    """
    if gone:
        return "window-closed"
    if outcome.trouble:
        return "failed"
    played = outcome.recording is not None and outcome.tally.performances
    return "finished" if played and outcome.stopped in (None, "practised") else "stopped"


def _calibrate(loaded: LoadedStudy, call: BlockCall, step: Calibration) -> Played:
    """Measure how long the participant takes; the trials and their fits lie in the participant's own
    folder.
    """
    import os

    from arl_tui.commands.calibrate import (
        HINDRANCES,
        check_files,
        hindrances,
        refuse_where_times_mean_nothing,
    )
    from arl_tui.drawing_rate import FRAMES_PER_S

    refuse_where_times_mean_nothing()
    os.environ.setdefault("TEXTUAL_FPS", FRAMES_PER_S)
    from arl_tui.calibration.app import CalibrationApp
    from arl_tui.calibration.plan import CalibrationSetup

    check_files(call.folder, call.code)
    setup = CalibrationSetup(
        participant=call.code,
        configs=calibration_configs(loaded, step),
        root_seed=call.seed,
        recordings=call.folder,
        hindrances=tuple(HINDRANCES[name] for name in hindrances()),
        language=loaded.study.language,
    )
    app = CalibrationApp(setup, theme=loaded.theme)
    app.before_leaving = call.on_gone
    outcome = app.run_in_terminal()
    if outcome is None or app.ended_by is not None:
        return Played(how="window-closed")
    names = [str(path.relative_to(call.folder)) for path in outcome.files]
    failures = [f"{task}: no fit: {reason}" for task, reason in outcome.fitted.failures.items()]
    warnings = [f"{delay.key}: beware: {text}" for delay in outcome.fitted.delays for text in delay.warnings]
    return Played(
        how="failed" if outcome.trouble else "finished" if outcome.finished else "stopped",
        file=names[0] if names else "",
        more_files=tuple(names[1:]),
        trouble=outcome.trouble or "",
        remark="\n".join([*failures, *warnings]),
    )
