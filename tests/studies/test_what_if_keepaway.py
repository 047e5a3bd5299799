"""What a recording of Keepaway teaches under other credit rules."""

import math
from pathlib import Path

import msgspec
import numpy as np
import pytest

from core.events import EpisodeStarted, StepTaken
from core.feedback.delays import CurrentStep, GammaDelay
from core.keepaway.sessions import KeepawayGame
from core.recording.reader import RecordingError, read_recording
from core.recording.recorder import LineWriter
from core.session.protocol_reading import protocol_from
from core.session.what_if import watched_steps
from core.tetris.plugin import TETRIS
from studies.what_if import WhatIfSettings, what_if

GOLDEN = (
    Path(__file__).resolve().parents[2] / "recordings" / "reference" / "keepaway-exponential-equation-4.jsonl"
)


@pytest.fixture(scope="module")
def rows():
    protocol = protocol_from(read_recording(GOLDEN).header.protocol)
    settings = WhatIfSettings(games=4, piece_cap=100)
    return what_if(
        GOLDEN, protocol, [GammaDelay(), CurrentStep()], ["exponential", "environment-only"], settings
    )


def test_every_rule_and_scheme_has_its_row(rows):
    assert [(row.credit.split(":")[0], row.scheme) for row in rows] == [
        (credit, scheme) for credit in ("gamma", "current") for scheme in ("exponential", "environment-only")
    ]


def test_durations_are_those_of_fresh_episodes(rows):
    for row in rows:
        assert 1.0 < row.lines.low <= row.lines.estimate <= row.lines.high < 60.0


def test_the_human_model_foretells_presses_over_tiles(rows):
    losses = [row.held_out.log_loss for row in rows]
    assert all(math.isfinite(loss) for loss in losses)
    # The scheme plays no part in what the presses teach; the rule does.
    assert losses[0] == losses[1] != losses[2] == losses[3]


def test_the_density_reaches_back_and_the_rule_does_not(rows):
    gamma, _, current, _ = rows
    assert 0.3 < gamma.credited < 1.0
    assert current.credited <= 1.0
    assert gamma.credited != current.credited
    assert len(gamma.trust) == 4


def changed(folder: Path, *, seeds: bool, states: bool) -> Path:
    """Write the golden recording without states, or with other episode seeds: as if the simulator had changed
    since."""
    recording = read_recording(GOLDEN)
    writer = LineWriter(folder / "changed.jsonl", recording.header)
    for event in recording.events:
        match event:
            case StepTaken() if states:
                writer.write(msgspec.structs.replace(event, state=None))
            case EpisodeStarted() if seeds:
                writer.write(msgspec.structs.replace(event, episode_seed=event.episode_seed + 1))
            case _:
                writer.write(event)
    writer.close()
    return folder / "changed.jsonl"


def steps_in(path: Path):
    recording = read_recording(path)
    return watched_steps(recording, protocol_from(recording.header.protocol))


def test_recorded_states_are_those_that_the_simulator_makes_again(tmp_path):
    recorded, simulated = steps_in(GOLDEN), steps_in(changed(tmp_path, seeds=False, states=True))
    assert recorded.keys() == simulated.keys()
    for number, step in recorded.items():
        np.testing.assert_array_equal(step.taken, simulated[number].taken)
        np.testing.assert_array_equal(step.choices.features, simulated[number].choices.features)
        assert (step.choices.actor, step.choices.time) == (
            simulated[number].choices.actor,
            simulated[number].choices.time,
        )


def test_a_recording_outlives_the_simulator_that_made_it(tmp_path):
    before, after = steps_in(GOLDEN), steps_in(changed(tmp_path, seeds=True, states=False))
    assert all((before[number].taken == after[number].taken).all() for number in before)


def test_a_recording_without_states_that_comes_out_otherwise_is_refused(tmp_path):
    with pytest.raises(
        RecordingError,
        match=r"changed.jsonl: step \d+ was .*keepaway has changed since.* does not name the commit",
    ):
        steps_in(changed(tmp_path, seeds=True, states=True))


def test_a_state_of_another_game_is_refused():
    recording = read_recording(GOLDEN)
    protocol = protocol_from(recording.header.protocol)
    more = msgspec.structs.replace(protocol.domain, n_keepers=4, n_takers=3)
    with pytest.raises(
        RecordingError, match=r"jsonl: step 0: need a state of 19 variables.*of another size\?"
    ):
        watched_steps(recording, msgspec.structs.replace(protocol, domain=more))
    with pytest.raises(RecordingError, match="a recording of keepaway, and the protocol is about tetris"):
        watched_steps(recording, TETRIS)
    step = next(event for event in recording.events if isinstance(event, StepTaken))
    with pytest.raises(ValueError, match=r"need a state of 13 variables, got \[1.0\]"):
        KeepawayGame().recorded(KeepawayGame().domain(protocol), msgspec.structs.replace(step, state=[1.0]))
