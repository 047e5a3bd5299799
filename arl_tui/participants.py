"""What is known of a participant's delays: one JSON file per pseudonym, beside the recordings.

`arl calibrate` writes it, `arl play --credit ...` and `arl replay --credit ...` read it. Every number can be
worked out again from the trial files that it names.
"""

import shlex
import subprocess
import sys
from pathlib import Path

import msgspec

from core.feedback.delays import Delay, GammaDelay, describe, parse_delay
from core.numerics.clock import wall_time_utc
from core.system.foreign_text import printable
from core.system.private_files import make_private_folder, write_private
from studies.reaction_time.protocol import Task

FORMAT = "arl-participant-delays"
VERSION = 1
FOLDER = "participants"
FEEDBACK_LAG: Task = "feedback lag"
SIMPLE: Task = "simple"
CHOICES = ("participant", "feedback-lag", "simple", "pooled", "paper")
"""Names for a participant's delays; "participant" is the feedback lag: the delay that credit needs."""
MEASURED = ("participant", "feedback-lag", "simple", "pooled")
"""Those of them that need a fit of the participant's."""
FEWEST_TRUSTED = 20
"""Fewer responses than this do not make a density of one's own (`docs/trusting-a-fit.md`)."""

LONGEST_CODE = 32
LARGEST_FILE = 1 << 20
"""Bytes of a file of delays: it has some hundred per task."""

LATE_MS = 60
"""A stimulus waits for the next frame, 33 ms at most, and for being drawn. Later says that the program was
held up."""
MOST_LATE = 0.1
"""Fraction of late trials from which on the measurement should not be trusted."""


class ParticipantError(ValueError):
    """There is no such fit, or its file cannot be used; the message says what to do."""


class Quantity(msgspec.Struct, frozen=True, array_like=True):
    """An estimate with its 95 % interval, seconds."""

    estimate: float
    low: float
    high: float


class TaskDelay(msgspec.Struct, frozen=True, kw_only=True):
    """How long one person took in one task."""

    task: Task
    game: str = "tetris"
    """Which game was watched in the feedback-lag task."""
    fitted_utc: str
    files: tuple[str, ...]
    """Names of the trial files."""
    family: str
    """The gamma that fits better by AIC: "gamma" (the paper's, offset 0) or "shifted gamma"."""
    delay: GammaDelay
    mean_s: Quantity
    median_s: Quantity
    n_observed: int
    n_censored: int
    """Trials that ended without a response: the time lies above the time-out."""
    left_out: dict[str, int]
    """Verdict to number of trials that are not in the fit."""
    policy: dict[str, object]
    """The exclusion policy."""
    shape_identified: bool
    shape_reason: str
    verdict: str
    """Whether another family of densities fits better, in words."""
    connection: dict[str, str] = {}
    """What stood between keyboard and program: connection, multiplexer, hindrances."""
    n_late: int = 0
    """Scored trials whose stimulus left the program later than `LATE_MS` after it was due."""
    pooled: GammaDelay | None = None
    """Own data and the other participants' together (gamma, offset 0); None with fewer than five people."""
    pooled_people: int = 0

    @property
    def key(self) -> str:
        """Under which name it is kept: the task, with the game where that is not Tetris."""
        return task_key(self.task, self.game)

    @property
    def warnings(self) -> list[str]:
        """Return in plain words why this delay should not be trusted, or not fully."""
        found = []
        if self.n_observed < FEWEST_TRUSTED:
            found.append(f"only {self.n_observed} responses: repeat the task, or use the pooled delay")
        elif not self.shape_identified:
            found.append(self.shape_reason)
        n_trials = self.n_observed + self.n_censored
        if self.n_late > MOST_LATE * n_trials:
            found.append(
                f"the computer was busy: in {self.n_late} trials the stimulus came more than {LATE_MS} ms "
                "late, and keys may have been read late, too; close other programs and repeat the task"
            )
        if self.connection.get("hindrances"):
            found.append(f"measured through {self.connection['hindrances']}: times may be too long")
        return found


def task_of(choice: str) -> Task:
    """Return the task behind one of the `MEASURED` choices."""
    return SIMPLE if choice == "simple" else FEEDBACK_LAG


def task_key(task: Task, game: str) -> str:
    """Return the name under which a delay is kept."""
    return task if game == "tetris" or task != FEEDBACK_LAG else f"{task}, {game}"


class ParticipantDelays(msgspec.Struct, frozen=True, kw_only=True):
    """All tasks of one participant: the newest fit of each."""

    format: str = FORMAT
    version: int = VERSION
    participant: str
    """Pseudonym; never a name."""
    tasks: dict[str, TaskDelay] = {}


class GroupDelay(msgspec.Struct, frozen=True, kw_only=True):
    """The delay of the typical participant of a group."""

    delay: GammaDelay
    n_people: int
    files: tuple[str, ...]
    """Names of the trial files."""


class CreditChoice(msgspec.Struct, frozen=True):
    """The credit rule of a session, and where it comes from."""

    delay: Delay
    source: dict[str, str]
    """For the recording's header."""
    warnings: tuple[str, ...] = ()


def wrong_code(text: str) -> str:
    """Return why a text is no participant's code, wherever it comes from; "" where it is one.

    Codes become names of files.
    """
    if 0 < len(text) <= LONGEST_CODE and all(letter.isalnum() or letter in "-_" for letter in text):
        return ""
    return (
        f"{printable(text)!r}: a participant's code has up to {LONGEST_CODE} letters, digits, '-' or '_', "
        "such as P01 - never a name"
    )


def delays_path(recordings: Path, participant: str) -> Path:
    """Return where a participant's delays are kept.

    Raises:
        ParticipantError: the code is none; it may come from another participant's file.
    """
    reason = wrong_code(participant)
    if reason:
        raise ParticipantError(reason)
    return recordings / FOLDER / f"{participant}.json"


def read_delays(recordings: Path, participant: str) -> ParticipantDelays | None:
    """Return what is known of a participant; None where nothing is.

    Raises:
        ParticipantError: the file is damaged, of another version, or another participant's.
    """
    path = delays_path(recordings, participant)
    try:
        with path.open("rb") as file:
            content = file.read(LARGEST_FILE + 1)
    except FileNotFoundError:
        return None
    if len(content) > LARGEST_FILE:
        raise ParticipantError(f"{path}: more than {LARGEST_FILE:,} bytes: not a participant's delays")
    try:
        delays = msgspec.json.decode(content, type=ParticipantDelays)
    except (msgspec.MsgspecError, ValueError, RecursionError) as error:
        raise ParticipantError(f"{path}: not a participant's delays: {error}") from error
    if (delays.format, delays.version, delays.participant) != (FORMAT, VERSION, participant):
        raise ParticipantError(
            f"{path}: expected {FORMAT} version {VERSION} of {participant}, got {delays.format} version "
            f"{delays.version} of {delays.participant}; `arl calibrate --participant "
            f"{shlex.quote(participant)}` makes a new one"
        )
    return delays


def keep_delay(recordings: Path, participant: str, delay: TaskDelay) -> Path:
    """Store one task's delay beside the others of this participant; the file is whole at every moment."""
    known = read_delays(recordings, participant) or ParticipantDelays(participant=participant)
    updated = msgspec.structs.replace(known, tasks={**known.tasks, delay.key: delay})
    path = delays_path(recordings, participant)
    make_private_folder(path.parent)
    write_private(path, msgspec.json.format(msgspec.json.encode(updated), indent=1) + b"\n")
    return path


def choose_credit(text: str, recordings: Path, participant: str, game: str = "tetris") -> CreditChoice:
    """Return the credit rule that `text` names: one of `CHOICES`, or a rule such as gamma:2.5,0.3.

    Args:
        text: from the command line.
        recordings: folder beside which participants' delays are kept.
        participant: whose delays "participant", "feedback-lag", "simple" and "pooled" mean.
        game: of the session; events of different games take different times to judge.

    Raises:
        ParticipantError: the participant has no such fit.
        ValueError: the rule is unknown.
    """
    if text == "paper":
        return _chosen(text, GammaDelay(), {})
    if text not in CHOICES:
        return _chosen(text, parse_delay(text), {})
    task = task_of(text)
    known = read_delays(recordings, participant)
    key = task_key(task, game)
    fit = None if known is None else known.tasks.get(key)
    if fit is None:
        option = task.replace(" ", "-") + (f" --game {game}" if key != task else "")
        raise ParticipantError(
            f"{participant} has no fit of the task {key!r} in {delays_path(recordings, participant)}. "
            f"Measure it: "
            f"`arl calibrate --participant {shlex.quote(participant)} --tasks {option}`; or choose --credit "
            f"paper"
        )
    about = {
        "credit_participant": participant,
        "credit_task": key,
        "credit_fitted_utc": fit.fitted_utc,
        "credit_files": " ".join(fit.files),
    }
    warnings = list(fit.warnings)
    if task == SIMPLE:
        warnings.append("a simple reaction is not an evaluation: feedback takes longer (use feedback-lag)")
    if text != "pooled":
        return _chosen(text, fit.delay, about, warnings)
    if fit.pooled is None:
        raise ParticipantError(
            f"{participant}: pooling needs at least five participants with a finished {task!r} task at the "
            "time of the fit; choose --credit participant"
        )
    about["credit_people"] = str(fit.pooled_people)
    return _chosen(text, fit.pooled, about)


def group_credit(recordings: Path, game: str) -> CreditChoice:
    """Return the typical participant's delay of judging a game: the middle of the folder's group.

    Args:
        recordings: folder with the trials of the others, at least five.
        game: which was judged.

    Raises:
        ParticipantError: there are fewer than five, or their trials cannot be fitted.
    """
    order = msgspec.json.encode({"recordings": str(recordings), "game": game})
    # A process of its own: statistics load slowly, and the screen's process never has them.
    done = subprocess.run(
        [sys.executable, "-m", "arl_tui.calibration.group"], input=order, capture_output=True, check=False
    )
    if done.returncode != 0:
        reason = done.stderr.decode(errors="replace").strip().splitlines() or ["no answer"]
        raise ParticipantError(
            f"no pooled delay of judging {game} from the trials in {recordings}: {reason[-1]}"
        )
    found = msgspec.json.decode(done.stdout, type=GroupDelay)
    about = {
        "credit_task": task_key(FEEDBACK_LAG, game),
        "credit_fitted_utc": wall_time_utc(),
        "credit_files": " ".join(found.files),
        "credit_people": str(found.n_people),
    }
    return _chosen("pooled", found.delay, about)


def rule_as_written(delay: Delay) -> CreditChoice:
    """Return the choice of a rule that stands in the protocol."""
    return _chosen("rule", delay, {})


def _chosen(
    text: str, delay: Delay, about: dict[str, str], warnings: list[str] | None = None
) -> CreditChoice:
    source = {"credit": text, "credit_rule": describe(delay), **about}
    return CreditChoice(delay, source, tuple(warnings or ()))


def home_of(recording: Path) -> Path:
    """Return the folder beside which the participants of a recording are kept: its own, or the nearest
    above.
    """
    folder = recording.resolve().parent
    return next((above for above in (folder, *folder.parents) if (above / FOLDER).is_dir()), folder)
