"""A report of few trials says how few they are, and what that does to its intervals."""

from pathlib import Path

import numpy as np
import pytest

from core.numerics.streams import stream
from studies.experiments.page import Page, write_page
from studies.statistics import _COVERAGE, FEW_TRIALS, few_trials_note, mean_interval


def test_ten_trials_are_enough_to_say_nothing() -> None:
    assert few_trials_note(FEW_TRIALS) is None
    assert set(_COVERAGE) == set(range(2, FEW_TRIALS))


def test_three_trials_are_said_to_be_three_with_what_they_cannot_show() -> None:
    said = few_trials_note(3)
    assert said is not None
    assert "Only 3 trials" in said
    assert "about 74 % of cases" in said
    assert "No p value can be below 0.25 with 3 pairs" in said


def test_six_pairs_can_be_significant_and_one_trial_has_no_interval() -> None:
    assert "No p value" not in str(few_trials_note(6))
    assert "No p value can be below 0.062" in str(few_trials_note(5))
    assert "there is no interval and no test" in str(few_trials_note(1, "games"))


@pytest.mark.statistical
@pytest.mark.parametrize("n", sorted(_COVERAGE))
def test_the_interval_holds_the_true_mean_as_often_as_is_said(n: int) -> None:
    rng = stream(7, "coverage", n)
    samples = 800
    for place, values in enumerate((rng.normal(1.0, 1.0, (samples, n)), rng.exponential(1.0, (samples, n)))):
        intervals = [mean_interval(row, rng=rng, resamples=400) for row in values]
        held = np.mean([found.low <= 1.0 <= found.high for found in intervals])
        expected = _COVERAGE[n][place] / 100
        # Four standard errors of both simulations, and the rounding of the table.
        error = np.sqrt(expected * (1 - expected) * (1 / samples + 1 / 3000))
        assert held == pytest.approx(expected, abs=4 * error + 0.005)


@pytest.mark.parametrize(("trials", "said"), [(3, True), (20, False), (None, False)])
def test_a_page_of_few_trials_says_so_first(tmp_path: Path, trials: int | None, said: bool) -> None:
    path, *_ = write_page(Page("x", "# Title\n\nText.\n"), tmp_path, trials=trials)
    text = path.read_text()
    assert text.startswith("# Title\n\n")
    assert ("**Few trials.** Only 3 trials" in text) == said
    assert "\nText.\n" in text


def test_a_quick_page_of_few_trials_says_both(tmp_path: Path) -> None:
    path, *_ = write_page(Page("x", "# Title\n\nText.\n"), tmp_path, quick=True, trials=2)
    text = path.read_text()
    assert text.index("**A quick run:**") < text.index("**Few trials.**") < text.index("Text.")
