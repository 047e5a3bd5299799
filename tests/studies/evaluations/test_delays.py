"""What the page of delays computes: credit of judged steps, the part of people and of values."""

import re

import numpy as np
import pytest

from core.feedback.delays import GammaDelay
from core.numerics.streams import stream
from studies.evaluations import delays_page
from studies.evaluations.delays import (
    ONSET,
    Delays,
    by_value,
    credit_on_target,
    evaluations,
    fractions_of_variance,
    reactions,
)
from tests.data_folder import REPOSITORY, data_folder

N = 60


def made(n_people: int = 8, *, spread: float = 1.0, strong: float = 1.0, name: str = "made") -> Delays:
    """People whose scales go from 1/spread to spread; values of size 2 take `strong` times as long."""
    times, values = {}, {}
    for k in range(n_people):
        rng = stream(7, "delays", k)
        said = rng.choice([-2.0, -1.0, 1.0, 2.0], N)
        scale = 0.3 * spread ** np.linspace(-1, 1, n_people)[k]
        times[f"P{k}"] = 0.11 + rng.gamma(3.0, scale, N) * np.where(np.abs(said) == 2, strong, 1.0)
        values[f"P{k}"] = said
    return Delays(
        name=name,
        source="Made here",
        licence="none",
        slow_above_s=10.0,
        times_s=times,
        values=values,
        left_out=0,
    )


def mean_shares(delays: Delays, **options: object) -> dict[str, float]:
    found = credit_on_target(delays, **options)  # type: ignore[arg-type]
    return {one.rule: float(one.share[1.0].mean()) for one in found}


def test_credit_of_the_judged_step_is_what_adding_up_the_density_says():
    one = Delays(
        name="x",
        source="",
        licence="",
        slow_above_s=10.0,
        times_s={"A": np.tile([0.4, 0.4, 0.9, 0.9], 8), "B": np.tile([0.5, 0.5, 0.8, 0.8], 8)},
        values={},
        left_out=0,
    )
    shares = next(c for c in credit_on_target(one, ONSET) if c.rule.startswith("paper")).share
    fine = np.linspace(0.0, 3.0, 300_001)
    density = fine**1.5 * np.exp(-fine / 0.3) / (1.329340388179137 * 0.3**2.5)
    for step_s, found in shares.items():
        by_hand = [
            np.trapezoid(
                density[(fine >= d - step_s) & (fine <= d)], fine[(fine >= d - step_s) & (fine <= d)]
            )
            for d in (0.4, 0.9)
        ]
        assert found[0] == pytest.approx(np.mean(by_hand), abs=1e-4)


@pytest.mark.statistical
def test_a_true_density_gives_half_to_a_step_that_is_judged_by_its_appearance():
    rng = stream(3, "true density")
    truth = GammaDelay(shape=3.0, scale_s=0.3)
    # The probability transform of a true density is uniform: mean 1/2, sd 1/sqrt(12).
    u = truth.cdf(rng.gamma(3.0, 0.3, 4000))
    assert u.mean() == pytest.approx(0.5, abs=4 / np.sqrt(12 * 4000))


def test_knowing_the_person_helps_where_people_differ_and_not_where_they_do_not():
    differ, alike = mean_shares(made(spread=2.5)), mean_shares(made(spread=1.0))
    own, others = "a gamma of one's own", "one gamma of all others"
    assert differ[own] - differ[others] > 0.03
    assert abs(alike[own] - alike[others]) < 0.01


def test_knowing_the_value_helps_where_it_matters():
    gain = {
        strong: (
            mean_shares(made(strong=strong))["one's own, by the value's size"]
            - mean_shares(made(strong=strong))["a gamma of one's own"]
        )
        for strong in (0.4, 1.0)
    }
    assert gain[0.4] > 0.02
    assert abs(gain[1.0]) < 0.01


def test_the_ratio_of_a_value_is_that_within_people():
    found = {one.value: one for one in by_value(made(spread=2.5, strong=0.5))}
    assert found[2.0].ratio / found[1.0].ratio == pytest.approx(
        0.55, abs=0.08
    )  # 0.11 s of each is not scaled
    assert found[-2.0].ratio == pytest.approx(found[2.0].ratio, rel=0.15)
    assert all(one.people == 8 for one in found.values())


def test_shares_of_variance_are_those_of_people_and_of_values():
    shares = fractions_of_variance(made(spread=3.0))
    assert shares["person"] > 0.5
    assert shares["value"] < 0.02
    assert fractions_of_variance(made())["person"] < 0.05
    x = made(spread=1.0)
    alone = {name: np.full(N, 0.5 + i) for i, name in enumerate(x.times_s)}
    only_people = Delays(
        name="x", source="", licence="", slow_above_s=9.0, times_s=alone, values={}, left_out=0
    )
    assert fractions_of_variance(only_people)["person"] == pytest.approx(1.0)


@pytest.mark.jit
def test_the_page_holds_each_task_and_all_its_figures_are_finite():
    sets = [made(name="reactions"), made(spread=2.0, strong=0.6, name="evaluations")]
    text = delays_page.page(sets, sets[1])
    assert "nan" not in text.lower()
    assert "inf" not in re.findall(r"[a-z]+", text)
    assert text.count("| paper: gamma(2.5, 0.3) |") == 2
    assert "| +2 |" in text
    assert len(delays_page.figure(sets, sets[1]).axes) == 3


def test_without_data_the_command_says_what_to_name(capsys, monkeypatch, tmp_path):
    monkeypatch.delenv("ARL_DATA", raising=False)
    with pytest.raises(SystemExit):
        delays_page.main([str(tmp_path)])
    assert "set ARL_DATA" in capsys.readouterr().err
    monkeypatch.setenv("ARL_DATA", str(tmp_path))
    with pytest.raises(SystemExit):
        delays_page.main([str(tmp_path)])
    assert "charm.csv" in capsys.readouterr().err


def test_the_committed_page_states_the_real_evaluations_figures():
    one = evaluations(data_folder("evaluation_delays").parent)
    text = (REPOSITORY / "docs" / "results" / "delays.md").read_text()
    assert len(one.times_s) == 51
    assert f"51 people, {one.together.size:,} delays" in text
    for value in by_value(one):
        assert f"{value.n:,} | {value.quantiles_s[0]:.2f} | {value.quantiles_s[1]:.2f}" in text
    medians = {value.value: round(value.quantiles_s[1], 2) for value in by_value(one)}
    assert medians == {-2.0: 0.77, -1.0: 1.19, 0.0: 1.53, 1.0: 1.11, 2.0: 0.74}


def test_the_committed_page_states_the_reactions_counts():
    sets = reactions(data_folder("reaction_time").parent)
    text = (REPOSITORY / "docs" / "results" / "delays.md").read_text()
    for one in sets:
        assert f"{len(one.times_s)} people, {one.together.size:,} delays" in text
