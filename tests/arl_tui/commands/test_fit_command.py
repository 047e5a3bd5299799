"""`arl fit`: what it prints and writes, and with which status it refuses."""

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from arl_tui.cli import main
from core.numerics.clock import NS_PER_MS, ManualClock
from core.numerics.streams import stream
from studies.reaction_time.protocol import TaskConfig
from studies.reaction_time.report import read_result
from studies.reaction_time.schedule import make_schedule
from studies.reaction_time.trial import Trial
from studies.reaction_time.trial_log import TrialHeader, TrialWriter
from tests.data_folder import data_folder

QUICK = ("--resamples", "0", "--goodness", "0", "--workers", "1")


def run(*arguments: str | Path) -> Result:
    """Run `arl fit`; the reaction times of CSV files are in `rt_s` unless a later option says otherwise."""
    mapped = ("--column", "rt=rt_s") if str(arguments[0]).endswith(".csv") else ()
    return CliRunner().invoke(main, ["fit", *mapped, *map(str, arguments)])


def table(path: Path, people: dict[str, list[object]], heading: str = "rt_s") -> Path:
    lines = [
        f"participant_id,{heading}",
        *(f"{p},{value}" for p, values in people.items() for value in values),
    ]
    path.write_text("\n".join(lines) + "\n")
    return path


def times(n: int = 60, index: int = 0) -> list[float]:
    return [round(float(t), 4) for t in 0.2 + stream(5, "fit command", index).gamma(4.8, 0.065, n)]


# --- one participant ----------------------------------------------------------------------------------------


def test_one_participant_is_shown_with_families_intervals_sentences_and_plots(tmp_path: Path) -> None:
    path = table(tmp_path / "a.csv", {"P01": times()})
    result = run(path, "--resamples", "20", "--goodness", "19")
    assert result.exit_code == 0, result.output
    families = [line.split("  ")[0] for line in result.stdout.splitlines()]
    assert {"gamma", "shifted gamma", "ex-Gaussian", "shifted log-normal", "Wald", "Weibull"} <= set(families)
    for expected in (
        "AIC",
        "BIC",
        "95 % by profile likelihood",
        "goodness    p = ",
        "the gamma",
        "○ gamma",
        "Q-Q, gamma",
    ):
        assert expected in result.stdout
    assert "Warning: shifted gamma: Shape not identified" in result.stdout
    mean = next(line for line in result.stdout.splitlines() if line.startswith("mean (s)"))
    assert float(mean.split()[2]) == pytest.approx(np.mean(times()), abs=2e-4)


def test_milliseconds_give_the_same_fit_as_seconds(tmp_path: Path) -> None:
    in_s = run(table(tmp_path / "a.csv", {"P01": times()}), *QUICK, "--json", "-")
    in_ms = run(
        table(tmp_path / "b.csv", {"P01": [t * 1000 for t in times()]}, "latency"),
        *("--column", "rt=latency", "--unit", "ms"),
        *QUICK,
        *("--json", "-"),
    )
    shapes = [json.loads(r.stdout)["group"]["participants"]["P01"]["gamma"]["shape"] for r in (in_s, in_ms)]
    assert shapes[0] == pytest.approx(shapes[1], rel=1e-6)


@pytest.mark.jit
def test_time_outs_are_censored_where_it_is_said_how_long_they_waited(tmp_path: Path) -> None:
    path = table(tmp_path / "a.csv", {"P01": [*times(40), 0, 0, 0]})
    result = run(path, *QUICK, "--waited", "1.5")
    assert "P01: 40 responses, 3 timed out" in result.stdout
    assert "not defined (time-outs)" in result.stdout
    assert "3 no response" in run(path, *QUICK).stdout


# --- files --------------------------------------------------------------------------------------------------


def test_json_figure_and_page_are_written_and_the_json_is_what_sessions_read(tmp_path: Path) -> None:
    path = table(tmp_path / "a.csv", {"P01": times()})
    wanted = {name: tmp_path / name for name in ("r.json", "f.svg", "p.html")}
    result = run(
        path, *QUICK, "--json", wanted["r.json"], "--figure", wanted["f.svg"], "--html", wanted["p.html"]
    )
    assert result.exit_code == 0, result.output
    found = read_result(wanted["r.json"])
    assert found.files == ("a.csv",)
    assert found.group.participants["P01"].shifted_gamma.gamma_delay().offset_s < min(times())
    assert "<svg" in wanted["f.svg"].read_text()
    assert wanted["p.html"].read_text().startswith("<!doctype html>")


def test_a_report_folder_holds_everything_and_is_never_overwritten(tmp_path: Path) -> None:
    path = table(tmp_path / "a.csv", {"P01": times()})
    assert run(path, *QUICK, "--out", tmp_path / "r").exit_code == 0
    assert {"result.json", "rows.tsv", "report.html", "figures"} == {
        p.name for p in (tmp_path / "r").iterdir()
    }
    again = run(path, *QUICK, "--out", tmp_path / "r")
    assert again.exit_code == 2
    assert "never overwritten" in again.stderr


def test_a_folder_is_answered_with_the_files_to_name(tmp_path: Path) -> None:
    folder = tmp_path / "sub-01" / "beh"
    folder.mkdir(parents=True)
    assert "without a table or a recording in it" in run(tmp_path).output
    table(folder / "sub-01_beh.tsv", {"A": times()})
    (tmp_path / "dataset_description.json").write_text("{}")
    result = run(tmp_path)
    assert result.exit_code == 2
    told = " ".join(result.output.split())
    assert "a folder of 1 files that may hold reactions" in told
    assert f"arl fit {tmp_path}/*/*/*.tsv" in told


def test_a_figure_of_an_unknown_kind_is_refused(tmp_path: Path) -> None:
    result = run(table(tmp_path / "a.csv", {"P01": times()}), *QUICK, "--figure", tmp_path / "f.xyz")
    assert result.exit_code == 2
    assert "xyz" in result.stderr


def recording(path: Path, task: str, n_trials: int = 30) -> Path:
    schedule = make_schedule(TaskConfig(task=task, n_practice=2, n_trials=n_trials, catch_rate=0.0), 1)
    header = TrialHeader(participant="P07", created_utc="2026-03-01T10:00:00+00:00", schedule=schedule)
    clock = ManualClock()
    with TrialWriter.create(path, header) as writer:
        for plan in schedule.trials:
            trial = Trial(plan, schedule.block_of(plan.index), schedule, clock)
            clock.advance_ns(150 * NS_PER_MS)
            trial.poll()
            clock.advance_ns(round(plan.foreperiod_s * 1e9))
            trial.poll()
            trial.flushed(clock.now_ns())
            clock.advance_ns((300 + 7 * plan.index) * NS_PER_MS)
            trial.pressed(plan.expected_keys[0], clock.now_ns())
            writer.write(trial.record)
    return path


def test_our_own_recordings_are_read_without_any_option_and_practice_is_left_out(tmp_path: Path) -> None:
    result = run(recording(tmp_path / "P07.jsonl", "simple"), *QUICK, "--json", tmp_path / "r.json")
    assert result.exit_code == 0, result.output
    assert "30 kept; left out: 2 practice" in result.stdout
    assert read_result(tmp_path / "r.json").task == "simple"


def test_recordings_of_different_tasks_are_not_fitted_together(tmp_path: Path) -> None:
    result = run(recording(tmp_path / "a.jsonl", "simple"), recording(tmp_path / "b.jsonl", "choice"), *QUICK)
    assert result.exit_code == 2
    assert "simple (a.jsonl), choice (b.jsonl)" in result.stderr


# --- many participants --------------------------------------------------------------------------------------


@pytest.fixture
def five(tmp_path: Path) -> Path:
    return table(tmp_path / "five.csv", {f"P0{i}": times(25, i) for i in range(1, 6)})


@pytest.mark.jit
def test_many_participants_have_a_line_each_and_pool_on_demand(five: Path, tmp_path: Path) -> None:
    result = run(five, *QUICK, "--pooled", "--figure", tmp_path / "means.png")
    assert result.exit_code == 0, result.output
    assert sum(line.startswith("P0") and "shifted gamma" in line for line in result.stdout.splitlines()) == 5
    assert sum(line.startswith("P0") and line.endswith("%") for line in result.stdout.splitlines()) == 5
    assert "Best by AIC:" in result.stdout
    assert (tmp_path / "means.png").read_bytes().startswith(b"\x89PNG")
    assert "own data" not in run(five, *QUICK).stdout


def test_one_of_many_can_be_chosen_and_all_be_taken_as_one(five: Path) -> None:
    assert "P03: 25 responses" in run(five, *QUICK, "--only", "P03").stdout
    assert "everybody: 125 responses" in run(five, *QUICK, "--as-one").stdout
    unknown = run(five, *QUICK, "--only", "P9")
    assert unknown.exit_code == 2
    assert "no such participant" in unknown.stderr


@pytest.mark.jit
def test_the_result_does_not_depend_on_the_number_of_workers(five: Path) -> None:
    quick = ("--resamples", "5", "--goodness", "0", "--json", "-")
    alone, two = (json.loads(run(five, *quick, "--workers", n).stdout)["group"] for n in "12")
    assert alone == two


def test_bids_events_of_real_people_are_read(tmp_path: Path) -> None:
    path = data_folder("reaction_time") / "flanker_ds000102_events.tsv.gz"
    result = run(path, "--keep", "correctness=correct", "--only", "sub-01", "--only", "sub-02", *QUICK)
    assert result.exit_code == 0, result.output
    assert "Rows: 1230 read; 1230 kept; none left out." in result.stdout
    assert "sub-02: " in result.stdout


AIC_OF_257 = {"ex-Gaussian": -28_915, "shifted gamma": -28_707, "gamma": -27_365}
"""Published for the pooled go reactions of OpenNeuro ds000030, best first."""
AIC_OF_26 = {"shifted gamma": -655, "gamma": -536}
"""The same for the flanker of ds000102."""


@pytest.mark.jit
@pytest.mark.parametrize(
    ("name", "options", "n", "published"),
    [
        pytest.param(
            "stop_signal_ds000030_events.tsv.gz",
            ["--column", "rt=ReactionTime", "--unit", "s", "--keep", "TrialOutcome=SuccessfulGo"],
            24_111,
            AIC_OF_257,
            marks=pytest.mark.slow,
        ),
        ("flanker_ds000102_events.tsv.gz", ["--keep", "correctness=correct"], 1_230, AIC_OF_26),
    ],
)
def test_the_published_ranking_of_families_on_pooled_real_times_is_reproduced(
    name: str, options: list[str], n: int, published: dict[str, int]
) -> None:
    result = run(data_folder("reaction_time") / name, *options, "--as-one", *QUICK, "--json", "-")
    assert result.exit_code == 0, result.output
    (everybody,) = json.loads(result.stdout)["group"]["participants"].values()
    assert everybody["gamma"]["n_observed"] == n
    found = {fit["family"]: fit["aic"] for fit in everybody["fits"] if fit["family"] in published}
    assert list(found) == list(published)
    assert found == pytest.approx(published, abs=0.6)


# --- dirty input --------------------------------------------------------------------------------------------


def test_a_column_without_a_unit_is_refused_and_the_message_says_how_to_state_it(tmp_path: Path) -> None:
    result = run(table(tmp_path / "a.csv", {"P": times()}, "rt"), "--column", "rt=rt", *QUICK)
    assert result.exit_code == 2
    assert "has no unit" in result.stderr
    assert "--unit s|ms" in result.stderr
    assert "--column rt=rt_ms" in result.stderr


def test_milliseconds_called_seconds_are_refused(tmp_path: Path) -> None:
    path = table(tmp_path / "a.csv", {"P": [round(t * 1000) for t in times()]}, "rt")
    result = run(path, "--column", "rt=rt", "--unit", "s", *QUICK)
    assert result.exit_code == 2
    assert "look like ms" in result.stderr


def test_a_few_missing_and_zero_times_are_counted_and_left_out(tmp_path: Path) -> None:
    result = run(table(tmp_path / "a.csv", {"P": [*times(), "n/a", "", 0]}), *QUICK)
    assert result.exit_code == 0, result.output
    assert "60 kept; left out: 2 missing, 1 no response." in result.stdout


def test_a_negative_time_is_warned_of_with_its_place(tmp_path: Path) -> None:
    result = run(table(tmp_path / "a.csv", {"P": [*times(), -0.25]}), *QUICK)
    assert result.exit_code == 0
    assert "1 negative time, the first at a.csv:62 (-0.25 s)" in result.stderr


@pytest.mark.parametrize("fault", [-0.3, 420.0], ids=["negative", "milliseconds among seconds"])
def test_many_impossible_times_are_refused_unless_they_are_to_be_left_out(
    tmp_path: Path, fault: float
) -> None:
    path = table(tmp_path / "a.csv", {"P": [*times(), *[fault] * 6]})
    result = run(path, *QUICK)
    assert result.exit_code == 2
    assert "6 of 66 times" in result.stderr
    assert "a.csv:62" in result.stderr
    assert run(path, *QUICK, "--allow-faults").exit_code == 0


def test_whoever_cannot_be_fitted_is_named_and_the_others_are_fitted(tmp_path: Path) -> None:
    path = table(
        tmp_path / "a.csv", {"P": times(), "few": [0.3, 0.4], "even": [0.4] * 20, "absent": ["n/a"] * 9}
    )
    result = run(path, *QUICK)
    assert result.exit_code == 0, result.output
    assert "P: 60 responses" in result.stdout
    assert "Not fitted: few: 2 usable responses" in result.stdout
    assert "Not fitted: even: all 20 times are 0.4 s" in result.stdout
    assert "Not fitted: absent: 0 usable responses" in result.stdout


def test_a_decimal_comma_is_taken_only_where_it_is_said(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("rt_s;b\n" + "\n".join(f"{t};1".replace(".", ",") for t in times()) + "\n")
    refused = run(path, *QUICK)
    assert refused.exit_code == 2
    assert "`arl fit --decimal ,`" in refused.output
    plain = table(tmp_path / "b.csv", {"a": times()})
    commas = run(path, *QUICK, "--decimal", ",")
    assert commas.exit_code == 0, commas.output
    assert commas.stdout == run(plain, *QUICK).stdout
    path.write_text("rt_ms;b\n1.023;1\n")  # A point beside decimal commas: a thousand and something?
    thousands = run(path, "--column", "rt=rt_ms", *QUICK, "--decimal", ",")
    assert thousands.exit_code == 2
    assert "'1.023', not a number" in thousands.output


def test_conditions_that_are_not_looked_at_are_named_and_can_be_taken_apart(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    rows = [
        f"{p},{c},{o},{t * (1.5 if c == 'hard' else 1.0):.4f}"
        for p, o in (("P1", "old"), ("P2", "young"))
        for c in ("easy", "hard")
        for t in times(20)
    ]
    path.write_text("participant_id,load,age,rt_s\n" + "\n".join(rows) + "\n")
    together = run(path, *QUICK)
    assert "taken together whatever stands in the columns load (easy, hard)" in together.stderr
    assert "age" not in together.stderr  # One age per participant: no condition.
    assert "P1: 40 responses" in together.stdout
    apart = run(path, *QUICK, "--by", "load", "--json", "-")
    assert "taken together" not in apart.stderr
    people = json.loads(apart.stdout)["group"]["participants"]
    assert list(people) == ["P1 easy", "P1 hard", "P2 easy", "P2 hard"]
    easy, hard = (people[f"P1 {c}"]["gamma"]["estimates"]["mean_s"] for c in ("easy", "hard"))
    assert hard == pytest.approx(1.5 * easy, rel=1e-3)


def test_participants_that_may_be_one_are_warned_of(tmp_path: Path) -> None:
    path = table(tmp_path / "a.csv", {"P1": times(), "p01": times(), "Q": times(20, 1) * 2})
    result = run(path, *QUICK)
    assert result.exit_code == 0, result.output
    assert "'P1' and 'p01' may be one" in result.stderr
    assert "'P1' and 'p01' have the same 60 times" in result.stderr
    assert "each of the times of 'Q' is there twice" in result.stderr
    clean = run(table(tmp_path / "b.csv", {f"P{i}": times(20, i) for i in (1, 10, 11)}), *QUICK)
    assert "Warning: the" not in clean.stderr
    assert "twice" not in clean.stderr


def test_words_among_numbers_are_refused_with_file_and_line(tmp_path: Path) -> None:
    result = run(table(tmp_path / "a.csv", {"P": [*times(9), "fast"]}), *QUICK)
    assert result.exit_code == 2
    assert "a.csv:11" in result.stderr


def test_too_few_responses_are_refused_with_the_reason(tmp_path: Path) -> None:
    result = run(table(tmp_path / "a.csv", {"P": [0.3, 0.4, 0, 0]}), *QUICK)
    assert result.exit_code == 2
    assert "2 usable responses, need at least 5" in result.stderr
    assert "2 no response" in result.stderr


@pytest.mark.parametrize(
    "option", [("--column", "rt"), ("--column", "when=x"), ("--waited", "-1"), ("--pooled",)]
)
def test_options_that_cannot_be_meant_leave_with_status_2(tmp_path: Path, option: tuple[str, ...]) -> None:
    result = run(table(tmp_path / "a.csv", {"P": times()}), *QUICK, *option)
    assert result.exit_code == 2
    assert result.stderr
    assert "Traceback" not in result.output


# --- other programs' files, other tasks' limits, odd times --------------------------------------------------


def test_every_option_of_the_command_reaches_the_request() -> None:
    import dataclasses

    from arl_tui.commands.fit import Request, fit

    names = {parameter.name for parameter in fit.params} - {"files"}
    assert names == {field.name for field in dataclasses.fields(Request)}
