"""How often simulated participants of a study press: about as often as a person would within its budget."""

import tempfile
from dataclasses import replace
from pathlib import Path

import msgspec

from core.feedback.config import TrainerConfig
from core.feedback.simulated_participants import person
from core.numerics.streams import stream_seed
from core.recording.reader import read_recording
from core.session.protocol import Protocol
from core.session.protocol_reading import protocol_from
from studies.lab.config import Block
from studies.lab.read import LoadedStudy

USUAL_PART = 0.4
"""Presses as a part of the budget: 2 of 5 on average (paper, section 4)."""
MOST_PER_CHANCE = 0.8
"""Nobody presses more often per step that can be judged: trainers in TAMER's public logs, who have no
budget, press 0.8 to 2.8 times per piece, and the fewest of these is a press for eight pieces in ten."""
GAMES_TO_COUNT = 10
"""At most so many watched games are played to count the chances to press in a game."""


def presses_per_game(loaded: LoadedStudy, kind: str) -> float:
    """Return how many judgements a simulated participant of a kind aims at in a watched game.

    Args:
        loaded: the study; its `[simulated]` goes first, then the part of the budget that is usual.
        kind: of `core.feedback.simulated_participants.persons`.
    """
    wanted = loaded.study.simulated
    own: float | None = getattr(wanted, kind)
    if own is not None:
        return own
    if wanted.presses_per_game is not None:
        return wanted.presses_per_game
    return USUAL_PART * _first_protocol(loaded).keys.max_presses_per_episode


def chances_per_game(loaded: LoadedStudy) -> float:
    """Return how many steps of a watched game a participant can judge, on average over a few games.

    They are counted in a simulated session of the study's first condition, in which a participant judges
    whatever comes on screen.
    """
    condition, protocol = next(iter(loaded.protocols.items()))
    games = min(GAMES_TO_COUNT, protocol.session.episodes)
    eager = TrainerConfig(press_probability=1.0, max_presses=1_000_000, delay=protocol.trainer.delay)
    from studies.demo import simulate_session, summarise  # here: compiled code comes with it

    played = with_trainer(loaded, eager).simulated_protocol(condition, Block(games=games))
    with tempfile.TemporaryDirectory() as folder:
        seed = stream_seed(loaded.study.seed, "chances")
        path = simulate_session(played, seed, Path(folder) / "chances.jsonl", software={})
        found = summarise(read_recording(path))
    return (found.accepted + found.other_presses) / max(1, found.episodes)


def as_participant(loaded: LoadedStudy, kind: str, chances: float) -> LoadedStudy:
    """Return the study as it is played with a simulated participant of a kind.

    They press in a watched game as often as `presses_per_game` says on average, at any step as likely as at
    another, and at most as often as the study's budget allows. Their delay is that of the study's `[trainer]`
    where it names one, else that of their kind.

    Args:
        loaded: the study.
        kind: of `core.feedback.simulated_participants.persons`.
        chances: from `chances_per_game`.
    """
    protocol, usual = _first_protocol(loaded), person(kind)
    likely = presses_per_game(loaded, kind) / chances if chances > 0 else 0.0
    delay = protocol.trainer.delay
    trainer = msgspec.structs.replace(
        usual,
        press_probability=min(MOST_PER_CHANCE, likely),
        max_presses=protocol.keys.max_presses_per_episode,
        mean_presses=None,
        delay=usual.delay if delay == _usual_trainer(protocol).delay else delay,
    )
    return with_trainer(loaded, trainer)


def with_trainer(loaded: LoadedStudy, trainer: TrainerConfig) -> LoadedStudy:
    """Return the study with this simulated participant in every condition."""
    protocols = {
        name: msgspec.structs.replace(protocol, trainer=trainer)
        for name, protocol in loaded.protocols.items()
    }
    return replace(loaded, protocols=protocols)


def settings_without_effect(loaded: LoadedStudy) -> tuple[str, ...]:
    """Return the keys of the study's `[trainer]` that say nothing about its simulated participants: all but
    `delay`.
    """
    found = []
    for protocol in loaded.protocols.values():
        usual = msgspec.structs.asdict(_usual_trainer(protocol))
        own = msgspec.structs.asdict(protocol.trainer)
        found += [key for key in own if key != "delay" and own[key] != usual[key]]
    return tuple(dict.fromkeys(found))


def _first_protocol(loaded: LoadedStudy) -> Protocol:
    return next(iter(loaded.protocols.values()))


def _usual_trainer(protocol: Protocol) -> TrainerConfig:
    """Return the simulated participant of the game's default protocol."""
    return protocol_from({"domain": {"type": protocol.game}}).trainer
