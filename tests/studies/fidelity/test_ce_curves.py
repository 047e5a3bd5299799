"""Learning curves of the cross-entropy method lie among the published ones."""

from pathlib import Path

import numpy as np
import pytest

from core.tetris.config import TetrisConfig
from studies.fidelity import ce_curves
from studies.fidelity.ce_curves import CurvePoint, Setting
from tests.data_folder import data_root

PUBLISHED = data_root() / "tetris_ce_published_curves.csv"


def points(rules: str, noise: str, by_run: dict[int, list[float]]) -> list[CurvePoint]:
    return [
        CurvePoint(rules, noise, run, iteration, lines)
        for run, curve in by_run.items()
        for iteration, lines in enumerate(curve, start=1)
    ]


def test_a_median_is_compared_with_the_published_range_by_hand():
    published = points("published", "none", {0: [1.0], 1: [3.0], 2: [5.0]})
    inside = points("ours", "none", {0: [0.0], 1: [4.0], 2: [90.0]})
    (row,) = ce_curves.compare(inside, published, iterations=[1])
    assert (row.median, row.published_min, row.published_median, row.published_max) == (4.0, 1.0, 3.0, 5.0)
    assert row.inside
    outside = points("ours", "none", {0: [6.0], 1: [7.0], 2: [8.0]})
    assert not ce_curves.compare(outside, published, iterations=[1])[0].inside


def test_a_comparison_with_an_iteration_nobody_reached_is_refused():
    with pytest.raises(ValueError, match="iteration 2"):
        ce_curves.lines_at(points("ours", "none", {0: [1.0]}), "ours", "none", 2)


def test_every_condition_meets_the_same_seeds():
    planned = ce_curves.settings(["overflow", "reference"], seeds=(3, 4))
    assert len(planned) == len(set(planned)) == 2 * 3 * 2
    assert {setting.root_seed for setting in planned if setting.noise == "linear"} == {3, 4}


def test_a_short_run_is_a_pure_function_of_its_setting(tmp_path, monkeypatch):
    monkeypatch.setitem(ce_curves.RULES, "short", TetrisConfig(rows=4))
    one, other = (ce_curves.run_curve(Setting("short", "linear", 1), iterations=2) for _ in range(2))
    assert one == other
    assert [point.iteration for point in one] == [1, 2]
    path = tmp_path / "curves.csv"
    ce_curves.write_csv(one, path)
    assert [round(point.mean_lines, 4) for point in one] == [p.mean_lines for p in ce_curves.read_csv(path)]
    another = ce_curves.run_curve(Setting("short", "linear", 2), iterations=2)
    assert [p.mean_lines for p in another] != [p.mean_lines for p in one]


@pytest.mark.filterwarnings("default")
def test_the_figure_is_drawn_from_curves_alone(tmp_path):
    ours = [
        p for noise in ce_curves.NOISES for p in points("reference", noise, {0: [1.0, 2.0], 1: [2.0, 9.0]})
    ]
    published = [
        p for noise in ce_curves.NOISES for p in points("published", noise, {0: [1.0, 3.0], 1: [2.0, 5.0]})
    ]
    path: Path = tmp_path / "curves.png"
    ce_curves.draw(ours, published, path)
    assert path.read_bytes().startswith(b"\x89PNG")


@pytest.mark.slow
@pytest.mark.jit
@pytest.mark.statistical
@pytest.mark.parametrize("rules", ["reference", "fit-before-clear"])
def test_the_median_over_twelve_seeds_lies_inside_the_published_range(rules):
    if not PUBLISHED.exists():
        pytest.skip(f"no published curves at {PUBLISHED}: set ARL_DATA")
    published = ce_curves.read_published(PUBLISHED)
    ours = [point for curve in ce_curves.run_curves(ce_curves.settings([rules])) for point in curve]
    rows = ce_curves.compare(ours, published)
    assert len(rows) == len(ce_curves.NOISES) * len(ce_curves.COMPARED_ITERATIONS)
    outside = [row for row in rows if not row.inside]
    assert not outside
    # Were ours drawn from the distribution of the 10 published runs, the median of 12 would leave their range
    # in 1 to 2.5 of 100 comparisons (all of the 6 or 7 highest of 22 being ours, or of the lowest). The seeds
    # were fixed before the first run.
    assert np.all([row.median > 0 for row in rows])
