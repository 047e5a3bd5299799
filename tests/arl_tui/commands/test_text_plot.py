"""Plots of `arl fit` in text: bars, histograms, densities, scatters."""

import numpy as np
import pytest

from arl_tui.commands.text_plot import bar, beside, histogram, histogram_edges, scatter


def test_a_bar_is_as_long_as_its_share_to_an_eighth_of_a_column() -> None:
    assert bar(0.5, 4) == "██  "
    assert bar(9 / 32, 4) == "█▏  "  # 9 of 32 eighths
    assert bar(2.0, 2) == "██"


def test_the_histograms_bins_have_round_widths_and_hold_all_times() -> None:
    x = np.array([0.213, 0.3, 0.951])
    edges = histogram_edges(x)
    assert np.diff(edges) == pytest.approx(0.05)
    assert edges[0] == pytest.approx(0.2)
    assert np.histogram(x, bins=edges)[0].sum() == 3
    assert len(histogram_edges(np.array([0.3, 0.3 + 1e-4]))) <= 19


def test_marks_stand_where_the_density_is() -> None:
    lines = histogram(
        np.array([0.0, 0.1, 0.2]), np.array([4.0, 2.0]), {"flat": np.array([2.0, 2.0])}, width=8
    )
    assert lines[0].endswith("│████○███")
    assert lines[1].endswith("│████○")
    assert "○ flat" in lines[2]


def test_points_on_the_diagonal_cover_it_and_outliers_do_not() -> None:
    x = np.linspace(0.0, 1.0, 200)
    on, off = scatter(x, x), scatter(x, np.append(x[:-1], 2.0))
    assert not any("·" in line for line in on)
    assert sum("·" in line for line in off) > 3


def test_blocks_stand_side_by_side() -> None:
    assert beside(["a", "bb"], ["c"]) == ["a    c", "bb"]
