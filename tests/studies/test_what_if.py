"""Credit rule x scheme on one recording; and on real people's logs."""

import math
import re

import msgspec
import numpy as np
import pytest

from core.events import KeyPressed
from core.feedback.credit import CurrentStep, GammaDelay, PreviousStep
from core.recording.importers.tamer_log import import_tamer_log, tamer_protocol
from core.recording.importers.tamer_rows import TamerLogError
from core.recording.reader import Recording, read_recording
from core.session.protocol import Protocol, SessionConfig
from core.session.protocol_reading import protocol_from
from core.session.what_if import watched_steps
from studies.what_if import (
    WhatIfSettings,
    _platt_log_loss,
    _rate_log_loss,
    held_out_log_loss,
    what_if,
)
from tests.core.sessions import simulated
from tests.data_folder import data_files, data_folder

QUICK = WhatIfSettings(games=5, piece_cap=60)


def test_a_row_comes_for_every_credit_rule_and_scheme_in_order(tmp_path):
    recording = simulated(tmp_path)
    protocol = protocol_from(recording.header.protocol)
    noted = []
    rows = what_if(
        recording.path,
        protocol,
        [PreviousStep(), GammaDelay()],
        ["linear", "environment-only"],
        QUICK,
        on_progress=lambda: noted.append(1),
    )
    assert [(row.credit, row.scheme) for row in rows] == [
        ("previous", "linear"),
        ("previous", "environment-only"),
        ("gamma:2.5,0.3", "linear"),
        ("gamma:2.5,0.3", "environment-only"),
    ]
    assert len(noted) == 4
    assert all(len(row.trust) == 3 for row in rows)


@pytest.mark.jit
def test_the_rows_are_the_same_for_any_number_of_workers(tmp_path):
    recording = simulated(tmp_path)
    protocol = protocol_from(recording.header.protocol)
    arguments = (recording.path, protocol, [PreviousStep(), GammaDelay()], ["linear"], QUICK)
    alone, together = what_if(*arguments, workers=1), what_if(*arguments, workers=2)
    assert repr(alone) == repr(together)  # repr: NaN is not equal to itself


def test_an_unknown_scheme_is_refused_with_the_known_ones(tmp_path):
    recording = simulated(tmp_path)
    with pytest.raises(ValueError, match="unknown scheme 'liner': use one of linear, exponential"):
        what_if(recording.path, Protocol(), [PreviousStep()], ["liner"], QUICK)


def test_the_rate_of_praise_is_guessed_by_laplace():
    # 3 of 4 training presses praise: (3 + 1) / (4 + 2) = 2/3. Test: one praise, one blame.
    train = [(0.0, True)] * 3 + [(0.0, False)]
    expected = -(math.log(2 / 3) + math.log(1 / 3)) / 2
    assert _rate_log_loss(train, [(0.0, True), (0.0, False)]) == pytest.approx(expected)


def test_scores_that_separate_praise_from_blame_foretell_it():
    rng = np.random.default_rng(0)
    praise = rng.random(200) < 0.6
    pairs = [
        (float(s), bool(p)) for s, p in zip(praise + 0.3 * rng.standard_normal(200), praise, strict=True)
    ]
    assert _platt_log_loss(pairs[:150], pairs[150:]) < 0.3
    mixed = [(float(rng.standard_normal()), bool(p)) for p in praise]
    assert _platt_log_loss(mixed[:150], mixed[150:]) == pytest.approx(
        _rate_log_loss(mixed[:150], mixed[150:]), abs=0.05
    )


def test_too_few_presses_give_no_log_loss(tmp_path):
    recording = simulated(tmp_path)
    protocol = protocol_from(recording.header.protocol)
    events = [
        msgspec.structs.replace(event, verdict="other") if isinstance(event, KeyPressed) else event
        for event in recording.events
    ]
    silent = Recording(recording.path, recording.header, tuple(events), complete=True)
    held_out = held_out_log_loss(silent, protocol, watched_steps(recording, protocol))
    assert math.isnan(held_out.log_loss)
    assert math.isnan(held_out.of_the_rate)
    assert held_out.undefined == "no press counted"
    assert not held_out.worse


def test_presses_of_one_kind_give_no_log_loss_and_the_reason(tmp_path):
    recording = simulated(tmp_path)
    protocol = protocol_from(recording.header.protocol)
    events = [
        msgspec.structs.replace(event, value=1.0) if isinstance(event, KeyPressed) and event.value else event
        for event in recording.events
    ]
    praising = Recording(recording.path, recording.header, tuple(events), complete=True)
    held_out = held_out_log_loss(praising, protocol, watched_steps(recording, protocol))
    assert re.fullmatch(
        r"\d+ presses to learn from, all of them praise: it takes both kinds", held_out.undefined
    )


RULES = [PreviousStep(), CurrentStep(), GammaDelay()]

KNOWN_LINES = {"130": (0.0, 2.0), "137": (100.0, 600.0)}
"""Lines per game under previous-placement credit that an independent replay of these logs found, with
room."""


@pytest.mark.jit
@pytest.mark.parametrize("log", data_files("tamer_tetris", pattern="*.log"), ids=lambda path: path.stem)
def test_credit_decides_what_real_peoples_presses_teach(log, tmp_path):
    data_folder("tamer_tetris")
    try:
        import_tamer_log(log, tmp_path / "log.jsonl")
    except TamerLogError:
        pytest.skip(f"{log.name} is not a Tetris log")
    # The person alone: what an environment learner would have found meanwhile plays no part.
    protocol = msgspec.structs.replace(tamer_protocol(), session=SessionConfig(unseen_between=0))
    previous, current, gamma = what_if(
        tmp_path / "log.jsonl", protocol, RULES, ["human-only"], WhatIfSettings(games=40)
    )
    low, high = KNOWN_LINES.get(log.stem, (0.0, math.inf))
    assert low <= previous.lines.estimate <= high
    assert current.lines.estimate < 5
    if log.stem == "137":
        assert gamma.lines.low > previous.lines.high
    if previous.lines.estimate > 10:  # the person taught something
        assert previous.lines.low > current.lines.high
    assert read_recording(tmp_path / "log.jsonl").complete
