"""Commands that are printed can be copied: whatever a name or a path holds, a shell reads it as one word."""

import shlex
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from arl_tui.cli import main
from arl_tui.participants import ParticipantError, choose_credit
from core.numerics.streams import stream


def arl(*arguments: str | Path | int) -> Result:
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def test_fit_names_a_participant_and_condition_as_one_word(tmp_path: Path) -> None:
    rng = stream(1, "times")
    rows = [
        f"{name},{time:.4f}"
        for name in ("A easy", "A hard", "B easy", "B hard")
        for time in 0.25 + rng.gamma(4.0, 0.05, size=30)
    ]
    (tmp_path / "times.csv").write_text("participant_id,rt\n" + "\n".join(rows) + "\n")
    options = ("--column", "rt=rt", "--unit", "s", "--resamples", "0", "--goodness", "0", "--workers", "1")
    result = arl("fit", tmp_path / "times.csv", *options)
    assert result.exit_code == 0, result.output
    (line,) = [line for line in result.output.splitlines() if "--only" in line]
    words = shlex.split(line)
    assert words[words.index("--only") + 1] == "A easy"


def test_the_advice_to_calibrate_is_a_command(tmp_path: Path) -> None:
    with pytest.raises(ParticipantError) as caught:
        choose_credit("participant", tmp_path, "P-1", "tetris")
    command = str(caught.value).split("`")[1]
    assert shlex.split(command)[:4] == ["arl", "calibrate", "--participant", "P-1"]


def test_the_next_step_of_a_run_is_a_command(tmp_path: Path) -> None:
    out = tmp_path / "my results"
    options = ("--trials", 1, "--workers", 1, "--quick", "--only", "low", "--out", out)
    result = arl("experiment", "run", "tests.studies.tiny_experiment", *options)
    assert result.exit_code == 0, result.output
    command = shlex.split(result.output.split("Next: ")[1])
    assert command == [
        *("arl", "experiment", "report", "tests.studies.tiny_experiment"),
        *("--out", str(out), "--quick", "--only", "low"),
    ]
