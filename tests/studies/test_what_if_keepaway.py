"""What a recording of Keepaway teaches under other credit rules."""

import math
from pathlib import Path

import pytest

from core.feedback.delays import CurrentStep, GammaDelay
from core.protocol import protocol_from
from core.recording.reader import read_recording
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
    losses = [row.log_loss for row in rows]
    assert all(math.isfinite(loss) for loss in losses)
    # The scheme plays no part in what the presses teach; the rule does.
    assert losses[0] == losses[1] != losses[2] == losses[3]


def test_the_density_reaches_back_and_the_rule_does_not(rows):
    gamma, _, current, _ = rows
    assert 0.3 < gamma.credited < 1.0
    assert current.credited <= 1.0
    assert gamma.credited != current.credited
    assert len(gamma.w_h) == 4
