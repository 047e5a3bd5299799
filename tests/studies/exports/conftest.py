"""A folder of data as a lab has it: recordings of both versions, a study with answers, reaction trials."""

import shutil
from pathlib import Path

import pytest
from click.testing import CliRunner

from arl_tui.cli import main
from core.numerics.streams import stream
from studies.reaction_time.protocol import TaskConfig
from studies.reaction_time.schedule import make_schedule
from tests.arl_tui.trial_files import write_session

REPOSITORY = Path(__file__).resolve().parents[3]
REFERENCE = REPOSITORY / "recordings" / "reference"
STUDY = """
name = "small"
seed = 5
participants = 4
[protocol.session]
episodes = 2
watched_steps = 6
unseen_between = 2
[conditions.linear.agent.scheme]
type = "linear"
[conditions.annealed.agent.scheme]
type = "annealed"
[assignment]
type = "latin-square"
[[sittings]]
name = "day 1"
steps = [
  { type = "consent", text = "consent.md" },
  { type = "block" },
  { type = "questionnaire", questions = "own.toml" },
  { type = "block" },
  { type = "questionnaire", questions = "taught" },
  { type = "debriefing", text = "consent.md" },
]
"""
QUESTIONS = """
name = "own"
[[questions]]
type = "text"
id = "remark"
text = "Anything to say?"
[[questions]]
type = "choice"
id = "hand"
text = "Which hand?"
options = ["left", "right"]
"""


def run(*arguments: object) -> str:
    """Run `arl` and return what it prints; it must succeed."""
    result = CliRunner().invoke(main, [str(argument) for argument in arguments])
    assert result.exit_code == 0, result.output
    return result.output


@pytest.fixture(scope="session")
def study_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("study")
    (folder / "consent.md").write_text("# Consent\n" + "\nA paragraph.\n" * 30)
    (folder / "own.toml").write_text(QUESTIONS)
    (folder / "study.toml").write_text(STUDY)
    return folder / "study.toml"


@pytest.fixture(scope="session")
def lab(tmp_path_factory: pytest.TempPathFactory, study_file: Path) -> Path:
    """The folder; tests do not change it."""
    folder = tmp_path_factory.mktemp("lab")
    for name in ("tetris-linear-equation-4", "keepaway-exponential-equation-4"):
        shutil.copy(REFERENCE / f"{name}.jsonl", folder / f"{name}-old.jsonl")
        shutil.copy(REFERENCE / "version-2" / f"{name}.jsonl", folder / f"{name}.jsonl")
    run("study", "simulate", study_file, "--participants", 2, "--drawn", "none", "--recordings", folder)
    schedule = make_schedule(TaskConfig(n_practice=2, n_trials=12, catch_rate=0.0), root_seed=3)
    times_s = [0.2 + 0.3 * float(time) for time in stream(1, "times").random(14)]
    write_session(folder, "P01", schedule, times_s)
    return folder
