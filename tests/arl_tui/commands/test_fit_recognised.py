"""`arl fit` with files of other programs: what it recognises, leaves out and points out."""

from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from arl_tui.cli import main
from tests.arl_tui.commands.test_fit_command import QUICK, run, table, times


def gorilla(path: Path, n: int = 40) -> Path:
    head = "Event Index,Participant Private ID,Tree Node Key,Response Type,Response,Reaction Time,Correct"
    rows = [
        f"{i},71,task-a,{kind},j,{time},1"
        for i, (kind, time) in enumerate(
            [("info", 312.4), *(("response", round(1000 * t, 1)) for t in times(n)), ("timed out", 3000.1)]
        )
    ]
    path.write_text("\n".join([head, *rows, "END OF FILE,,,,,,"]) + "\n")
    return path


def fit_of(*arguments: str | Path) -> Result:
    return CliRunner().invoke(main, ["fit", *map(str, arguments), *QUICK])


def test_what_was_recognised_and_which_rows_were_taken_is_said_before_anything_else(tmp_path: Path) -> None:
    path = gorilla(tmp_path / "a.csv")
    result = fit_of(path)
    assert result.exit_code == 0, result.output
    first = result.stderr.splitlines()[:3]
    assert first[0].startswith("a.csv: Gorilla, Task Builder 2, by 'Participant Private ID'")
    assert first[1] == "  taken: 40 responses, 1 without a response"
    assert first[2] == "  left out: 1 Response Type 'info', 1 Gorilla's END OF FILE"
    assert "71: 40 responses, 1 timed out" in result.stdout
    assert fit_of(path, "--from", "gorilla").stdout == result.stdout
    for name, words in (
        ("psychopy", "it looks like Gorilla's (--from gorilla)"),
        ("gorila", "there are psychopy"),
    ):
        refused = fit_of(path, "--from", name)
        assert refused.exit_code == 2
        assert words in refused.stderr


def test_many_files_of_one_kind_are_described_together(tmp_path: Path) -> None:
    result = fit_of(*(gorilla(tmp_path / f"{i}.csv") for i in range(6)))
    assert "6 files: Gorilla" in result.stderr
    assert "  taken: 240 responses, 6 without a response" in result.stderr


def test_wrong_answers_are_left_out_unless_they_are_asked_for(tmp_path: Path) -> None:
    path = gorilla(tmp_path / "a.csv")
    text = path.read_text().splitlines()
    path.write_text("\n".join([*text[:2], text[2][:-1] + "0", *text[3:]]) + "\n")
    assert "39 kept, 1 timed out; left out: 1 wrong key" in fit_of(path).stdout
    assert "40 kept, 1 timed out; none left out" in fit_of(path, "--keep-wrong").stdout


def test_limits_belong_to_the_task_and_a_default_that_leaves_out_many_says_so_first(tmp_path: Path) -> None:
    slow = [*times(90), *[3.5 + 0.1 * i for i in range(10)]]
    path = table(tmp_path / "a.csv", {"P": slow})
    as_reactions = run(path, *QUICK)
    assert (
        "the limit for reactions of 3 s leaves out 10 of 100 responses (10.0%, up to 4.4 s)"
        in as_reactions.stderr
    )
    assert "--task evaluation takes them up to 10 s" in as_reactions.stderr
    as_evaluations = run(path, *QUICK, "--task", "evaluation")
    assert "Warning: the limit" not in as_evaluations.stderr
    assert "100 kept" in as_evaluations.stdout
    stated = run(path, *QUICK, "--slow-above", "3")
    assert "Warning: the limit" not in stated.stderr  # whoever states it knows
    assert "90 kept; left out: 10 slow" in stated.stdout


@pytest.mark.parametrize(
    ("hertz", "name"), [(60, "frames at 60 Hz"), (144, "frames at 144 Hz"), (64, "Windows clock")]
)
def test_times_in_steps_are_pointed_out_with_what_they_do_to_a_fit(
    tmp_path: Path, hertz: int, name: str
) -> None:
    stepped = [round(round(t * hertz) / hertz * 1000, 2) for t in times(120)]
    found = run(table(tmp_path / "a.csv", {"P": stepped}, "rt_ms"), "--column", "rt=rt_ms", *QUICK)
    assert f"'P' stand in steps of {1000 / hertz:.4g} ms" in found.stderr
    assert name in found.stderr
    for digits in (0, 2):  # whole milliseconds are no steps of a frame
        plain = [round(t * 1000, digits) for t in times(120)]
        clean = run(table(tmp_path / "b.csv", {"P": plain}, "rt_ms"), "--column", "rt=rt_ms", *QUICK)
        assert "in steps of" not in clean.stderr


@pytest.mark.jit
def test_a_pile_at_the_maximum_is_pointed_out_and_counts_as_time_outs_when_stated(tmp_path: Path) -> None:
    path = table(tmp_path / "a.csv", {"P": [*times(60), *[2.0] * 5]})
    result = run(path, *QUICK)
    assert "5 times of 'P' are exactly 2 s, the longest of all" in result.stderr
    assert "--waited 2 counts them as time-outs" in result.stderr
    stated = run(path, *QUICK, "--waited", "2")
    assert "P: 60 responses, 5 timed out" in stated.stdout
    assert "exactly 2 s" not in stated.stderr


# --- plots of text ------------------------------------------------------------------------------------------
