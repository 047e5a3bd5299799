"""Reports read files, never play; the same files give the same page."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from core.numerics.streams import stream
from studies.experiments import page
from studies.experiments.keepaway_pages import by_episode, weights_used
from studies.experiments.rates import AtRate, summary
from studies.experiments.results import read_results
from studies.experiments.run import SweepError, run_sweep
from studies.experiments.sweep import MODULES, csv_text, experiment_module, root_seeds
from studies.statistics import Interval
from tests.studies.experiments.test_experiment_runs import Inline

PAGES = ("fig5", "fig6", "features", "robustness", "robustness-keepaway")


@pytest.fixture(autouse=True)
def _few_resamples(monkeypatch):
    """Intervals need not be exact here."""
    monkeypatch.setattr(page, "RESAMPLES", 300)


def games(seed: int, condition: str, gain: float, episodes: int = 200) -> dict[str, np.ndarray]:
    """Rows as a trial of either game returns them, the condition `gain` times as good."""
    rng = stream(seed, "games")
    lines = np.floor(gain * rng.exponential(np.linspace(1.0, 40.0, episodes)))
    return {
        "lines": lines,
        "pieces": 2.5 * lines + 20,
        "presses": rng.integers(0, 6, size=episodes).astype(float),
        "w_h": np.full(episodes, 0.4),
        "seconds": gain * (1.0 + rng.exponential(8.0, episodes)),
        "hours": np.linspace(0.01, 2.0, episodes),
    }


def played(
    name: str,
    folder: Path,
    gains: dict[str, float],
    trials: int = 6,
    commit: str = "abc",
    *,
    quick: bool = False,
):
    """Return results of an experiment whose trials were never played."""

    class Made(Inline):
        def submit(self, fn, /, experiment, condition, seed, quick):
            return super().submit(lambda *_: csv_text(games(seed, condition, gains.get(condition, 1.0))))

    experiment = experiment_module(name).EXPERIMENT
    run_sweep(experiment, root_seeds(trials), folder, Made(), software={"commit": commit}, quick=quick)
    never = dataclasses.replace(experiment, trial=lambda *_: pytest.fail("a report must not play"))
    return read_results(never, folder)


@pytest.mark.parametrize("name", PAGES)
def test_a_page_says_what_held_and_how_to_do_it_again(name, tmp_path):
    found = experiment_module(name).report(played(name, tmp_path, {}))
    assert found.name == name
    for expected in (
        "abc",
        f"arl experiment run {name}",
        "root seeds 0 to 5",
        "Departures",
        f"figures/{name}.png",
    ):
        assert expected in found.text
    written = page.write_page(found, tmp_path / "docs")
    assert sorted(path.suffix for path in written) == [".md", ".png", ".svg"]
    assert all(path.stat().st_size > 500 for path in written)


@pytest.mark.parametrize("name", ["fig5", "robustness-keepaway"])
def test_a_page_of_a_quick_run_says_so_first_and_names_the_commands_of_one(name, tmp_path):
    results = played(name, tmp_path / "quick", {}, quick=True)
    found = experiment_module(name).report(results)
    path, *_ = page.write_page(found, tmp_path, quick=results.record.quick)
    title, empty, note = path.read_text().splitlines()[:3]
    assert (title[:2], empty, note[:16]) == ("# ", "", "**A quick run:**")
    assert f"`arl experiment run {name} --quick && arl experiment report {name} --quick`" in found.text
    path, *_ = page.write_page(found, tmp_path / "whole")
    assert "quick run" not in path.read_text()


def test_the_weight_of_the_human_is_what_the_scheme_made_of_trust(tmp_path):
    # The files say 0.4 throughout: what Eq. 4 would have given, whatever the scheme.
    results = played("robustness-keepaway", tmp_path, {}, trials=1)
    assert weights_used(results, "eq4-10")[0, -1] == pytest.approx(0.4)
    assert weights_used(results, "constant-10").tolist() == [[1.0] * 10]
    # 200 episodes; the last tenth of the time holds the last twenty.
    assert weights_used(results, "annealed-10")[0, -1] == pytest.approx(
        np.mean(0.98 ** np.arange(180, 200)), rel=0.05
    )
    text = experiment_module("robustness-keepaway").report(results).text
    _, weights = text.split("Mean weight of the participant")
    assert "| constant w_h = 1 | 1.00 | 1.00 |" in weights


@pytest.mark.parametrize("name", ["fig5", "features"])
def test_the_same_files_give_the_same_page(name, tmp_path):
    results = played(name, tmp_path, {})
    report = experiment_module(name).report
    first, second = report(results), report(results)
    assert first.text == second.text
    first_files = page.write_page(first, tmp_path / "a")
    second_files = page.write_page(second, tmp_path / "b")
    assert [p.read_bytes() for p in first_files] == [p.read_bytes() for p in second_files]


def test_a_claim_holds_where_the_condition_is_better_and_not_otherwise(tmp_path):
    report = experiment_module("fig5").report
    better = report(played("fig5", tmp_path / "better", {"arl-ce": 3.0})).text
    assert better.count("| yes |") == 3
    worse = report(played("fig5", tmp_path / "worse", {"arl-ce": 0.3})).text
    assert worse.count("| no, the opposite |") == 3


@pytest.mark.parametrize(("gain_of_ce", "held"), [(3.0, "yes"), (0.3, "no, the opposite")])
def test_whether_policy_gradient_clears_fewer_lines_than_ce_is_computed(gain_of_ce, held, tmp_path):
    played("fig5", tmp_path / "fig5", {"ce": gain_of_ce}, commit="of CE")
    text = experiment_module("fig6").report(played("fig6", tmp_path / "fig6", {}, trials=8)).text
    (row,) = [line for line in text.splitlines() if line.startswith("| PG clears fewer lines than CE")]
    assert f"| {held} |" in row
    assert "6 trials pair by seed" in text
    assert "commit of CE" in text


def test_without_trials_of_ce_the_page_claims_nothing_about_it(tmp_path):
    text = experiment_module("fig6").report(played("fig6", tmp_path / "fig6", {})).text
    assert "is not tested on this page" in text
    assert "| PG clears fewer" not in text


@pytest.mark.parametrize("name", ["features", "robustness"])
def test_trials_that_two_experiments_share_are_compared_row_by_row(name, tmp_path):
    report = experiment_module(name).report
    alone = report(played(name, tmp_path / "alone" / name, {}))
    assert "their rows were not compared" in alone.text
    played("fig5", tmp_path / "fig5", {}, trials=4, commit="played them first")
    equal = report(played(name, tmp_path / name, {})).text
    n_shared = 4 * (2 if name == "features" else 3)
    assert f"{n_shared} that both have were compared row by row, all are equal" in " ".join(equal.split())
    assert "played them first" in equal
    first = {"features": "ce-21", "robustness": "environment"}[name]
    played("fig5", tmp_path / "more" / "fig5", {})
    differing = report(played(name, tmp_path / "more" / name, {first: 2.0})).text
    assert "**6 differ**" in differing


def test_a_page_says_which_conditions_have_too_few_trials_and_how_to_report_what_there_is(tmp_path):
    results = played("features", tmp_path, {})
    trials = {name: trial for name, trial in results.trials.items() if name != "ce-12"}
    fewer = dataclasses.replace(results, trials=trials, left_out={"ce-12": 2})
    with pytest.raises(SweepError, match=r"ce-12 \(2 trials\).*--only ce-21 --only ce-12"):
        experiment_module("features").report(fewer)


def test_the_goal_of_robustness_is_judged_demand_by_demand(tmp_path):
    report = experiment_module("robustness").report
    gains = {f"margin-{rate:03d}": 2.0 for rate in (0, 10, 30, 80, 100)}
    good = report(played("robustness", tmp_path / "good", gains)).text
    goal = good[good.index("## The goal") : good.index("## Every rule")]
    assert "**no**" not in goal
    assert goal.count("beats annealed at 95 %") == 2
    bad = report(played("robustness", tmp_path / "bad", {"margin-050": 0.5})).text
    goal = bad[bad.index("## The goal") : bad.index("## Every rule")]
    assert "never significantly below: **no**; nor 10 % below: **no**" in goal


def test_a_rules_ratio_stands_in_the_column_of_its_rate(tmp_path):
    text = (
        experiment_module("robustness-keepaway")
        .report(played("robustness-keepaway", tmp_path, {"margin-80": 3.0}))
        .text
    )
    (row,) = (line for line in text.splitlines() if line.startswith("| signed agreement with a margin | 1 "))
    cells = [cell.strip() for cell in row.strip("|").split("|")]
    assert [cell.startswith("3 [") for cell in cells[1:]] == [False] * 4 + [True, False]


def test_means_by_episode_are_over_blocks_that_every_trial_has(tmp_path):
    long, short = {"seconds": np.arange(20.0)}, {"seconds": np.arange(9.0)}
    results = dataclasses.replace(played("fig7", tmp_path, {}, trials=2), trials={"sarsa": (long, short)})
    last, means = by_episode(results, "sarsa", "seconds", bins=4)
    assert last.tolist() == [2, 4, 6, 8]
    assert means.tolist() == [[0.5, 2.5, 4.5, 6.5]] * 2
    assert len(by_episode(results, "sarsa", "seconds", bins=40)[0]) == 9


def test_rules_are_summed_up_by_their_intervals():
    def cells(**rates):
        return {
            int(rate[1:]): AtRate(Interval(middle, middle - 0.2, middle + 0.2), 0.0)
            for rate, middle in rates.items()
        }

    text = summary(
        {
            "careful": cells(r10=1.5, r80=1.0, r100=0.9),
            "clever": cells(r10=1.0, r80=1.3, r100=1.4),
            "rash": cells(r10=2.0, r80=1.3, r100=0.7),
            "untried": cells(r10=1.5),
        }
    )
    assert "at no rate: *careful*, *clever*, *untried*." in text
    assert "are\nwrong: *clever*." in text
    assert "at no rate: none." in summary({"rash": cells(r50=0.5)})


def test_trials_of_people_that_were_not_played_are_said_to_be_missing(tmp_path):
    results = played("robustness", tmp_path, {})
    kept = {
        name: trial for name, trial in results.trials.items() if not name.startswith(("person", "gradient"))
    }
    text = experiment_module("robustness").report(dataclasses.replace(results, trials=kept)).text
    assert text.count("These trials were not played.") == 2


def test_the_pages_of_robustness_say_with_whom_the_rule_gained_and_lost(tmp_path):
    gains = {"gradient-lay": 3.0, "gradient-100": 0.3}
    text = experiment_module("robustness").report(played("robustness", tmp_path / "tetris", gains)).text
    assert (
        "Significantly below policy gradient alone with: 100 % wrong. Significantly above it with: lay."
        in text
    )
    assert "| instructed |" in text.partition("## Simulated people by name")[2].partition("##")[0]
    gains = {"side-0": 2.0, "side-lay": 2.0}
    text = (
        experiment_module("robustness-keepaway")
        .report(played("robustness-keepaway", tmp_path / "keepaway", gains))
        .text
    )
    cells = next(line for line in text.splitlines() if line.startswith("| 0 % | 2")).split("|")[2:5]
    assert [float(cell.split()[0]) for cell in cells] == pytest.approx([2.0] * 3, rel=0.15)
    row = next(line for line in text.splitlines() if line.startswith("| lay |"))
    assert float(row.split("|")[2].split()[0]) == pytest.approx(2.0, rel=0.15)


def test_figure_4_comes_from_fits_and_says_what_they_misplace(tmp_path):
    module = experiment_module("fig4")
    rows = module.trial(module.EXPERIMENT.condition("paper-640").settings, 3)
    assert rows["shape"][0] == pytest.approx(2.5, abs=0.6)
    assert rows["mean_s"][0] == pytest.approx(0.75, abs=4 * 0.474 / np.sqrt(640))
    assert 0 <= rows["elsewhere"][0] < 0.1
    # Two gammas of which one lies 0.5 s later share less than all their mass; a density shares all with
    # itself.
    step_s = module.GRID_S[1]
    assert module.density(module.PAPER).sum() * step_s == pytest.approx(1.0, abs=0.002)
    run_sweep(module.EXPERIMENT, root_seeds(3), tmp_path, Inline())
    text = module.report(read_results(module.EXPERIMENT, tmp_path)).text
    assert "mean 0.75 s and mode 0.45 s" in text


def test_settings_are_split_into_what_is_shared_and_what_differs():
    common, own = page.shared_settings(
        {"a": {"x": 1, "y": {"p": 1, "q": 2}}, "b": {"x": 1, "y": {"p": 1, "q": 3}}}
    )
    assert common == {"x": 1, "y": {"p": 1}}
    assert own == {"a": {"y": {"q": 2}}, "b": {"y": {"q": 3}}}


def test_settings_that_only_some_conditions_have_are_named_with_them():
    rules = {
        "a": {"rule": {"type": "eq4"}},
        "b": {"rule": {"type": "signed", "margin": 0.1}, "seeds_from": 9},
    }
    common, own = page.shared_settings(rules)
    assert common == {}
    assert own == rules


def test_numbers_have_three_digits_and_no_exponent():
    assert [page.number(v) for v in (12345.6, 1.2345, 0.0, 0.00012345)] == ["12346", "1.23", "0", "0.0001"]


def test_every_experiment_can_be_reported():
    for name in MODULES:
        assert callable(experiment_module(name).report)
