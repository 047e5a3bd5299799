"""Which tasks a calibration has, and what of it has been done already: no screen, no keys."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from pathlib import Path

import msgspec

from arl_tui.games.registry import screens_called
from arl_tui.participants import FEEDBACK_LAG
from arl_tui.recordings import CALIBRATION_FOLDER
from core.plugins import GameError, plugin_called
from core.session.protocol import Protocol
from studies.lab.folder import group_folders
from studies.reaction_time.protocol import Schedule, Task, TaskConfig
from studies.reaction_time.schedule import expected_minutes, make_schedule
from studies.reaction_time.trial_log import LONGEST_PAUSE_H, TrialFile, read_trials

TASKS: dict[str, Task] = {
    "simple": "simple",
    "choice": "choice",
    "go-no-go": "go/no-go",
    "memory-search": "memory search",
    "visual-search": "visual search",
    "recognition": "recognition",
    "feedback-lag": "feedback lag",
}
"""Names on the command line, in the order in which they are run."""
JUDGING_S = 3.0
"""Time-out of the feedback-lag task: the paper's density reaches 1.7 s (95 %)."""
PLANNED = "planned_tasks"
"""Key in a trial file's facts: all tasks of the calibration."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CalibrationSetup:
    """Who is measured, how, and where it is written."""

    participant: str
    """Pseudonym; never a name."""
    configs: tuple[TaskConfig, ...]
    """The tasks, in order."""
    root_seed: int
    recordings: Path
    hindrances: tuple[str, ...] = ()
    """What stands between keyboard and program, in English; measuring needs an explicit yes then."""
    language: str = "en"
    """Of the words on screen."""

    @property
    def planned(self) -> str:
        """Names of the tasks, as they stand in the trial files."""
        return ",".join(slug(config) for config in self.configs)


@dataclass(frozen=True, slots=True)
class Part:
    """One task of a calibration, and what of it is done."""

    schedule: Schedule
    path: Path | None = None
    """The trial file; None where the task has not begun."""
    done: frozenset[int] = frozenset()
    """Trials that are finished."""

    @property
    def complete(self) -> bool:
        """Whether all trials are done."""
        return len(self.done) >= len(self.schedule.trials)


@dataclass(frozen=True, slots=True)
class Unfinished:
    """A calibration that stopped before its end."""

    parts: tuple[Part, ...]
    root_seed: int
    age_h: float

    @property
    def is_old(self) -> bool:
        """Whether it must not go on without being asked about: another day is another measurement."""
        return self.age_h > LONGEST_PAUSE_H


def task_names(text: str) -> tuple[str, ...]:
    """Return the tasks in a comma-separated list, each once, in our order.

    Raises:
        ValueError: one of them is unknown.
    """
    asked = [part.strip() for part in text.split(",") if part.strip()]
    unknown = [name for name in asked if name not in TASKS]
    if unknown or not asked:
        raise ValueError(f"unknown task {', '.join(unknown) or text!r}: choose from {', '.join(TASKS)}")
    return tuple(name for name in TASKS if name in asked)


def configure(
    names: Sequence[str],
    *,
    n_trials: int | None = None,
    n_practice: int | None = None,
    game: str = "tetris",
    protocol: Protocol | None = None,
) -> tuple[TaskConfig, ...]:
    """Return the configuration of each task.

    Args:
        names: keys of `TASKS`.
        n_trials: scored trials per task; the task's default without.
        n_practice: practice trials per task; the task's default without.
        game: which one is watched in the feedback-lag task.
        protocol: of the sessions for which the delay is measured; their pace is that of the task. The game's
            default without.

    Raises:
        GameError: the feedback-lag task is among them, and this game has none.
    """
    changes: dict[str, int] = {}
    if n_trials is not None:
        changes["n_trials"] = n_trials
    if n_practice is not None:
        changes["n_practice"] = n_practice
    configs = []
    for name in names:
        config = msgspec.structs.replace(TaskConfig(task=TASKS[name]), **changes)
        if config.task == FEEDBACK_LAG:
            if not screens_called(game).judging_module:
                raise GameError(
                    f"{plugin_called(game).title} has no feedback-lag task: its delay of judging cannot be "
                    "measured. Leave the task out, or measure the delay in a game that has it "
                    "(`arl calibrate --game tetris`)"
                )
            default = plugin_called(game).default()
            config = msgspec.structs.replace(
                config,
                time_out_s=JUDGING_S,
                game=game,
                picture_ms=screens_called(game).picture_ms((protocol or default).screen),
            )
        configs.append(config)
    return tuple(configs)


def slug(config: TaskConfig) -> str:
    """Return a task's name in file names: as on the command line, with the game where that is not Tetris."""
    name = next(name for name, known in TASKS.items() if known == config.task)
    return f"{name}-{config.game}" if config.game != "tetris" else name


def new_parts(setup: CalibrationSetup) -> tuple[Part, ...]:
    """Return the parts of a calibration that begins now."""
    return tuple(Part(make_schedule(config, setup.root_seed)) for config in setup.configs)


def minutes_left(parts: Sequence[Part]) -> float:
    """Return the expected length of what is not done, without breaks."""
    return sum(
        expected_minutes(part.schedule) * (1.0 - len(part.done) / len(part.schedule.trials)) for part in parts
    )


def unfinished(setup: CalibrationSetup, now_utc: str) -> Unfinished | None:
    """Return the participant's newest calibration if it had the same tasks and is not finished.

    Raises:
        TrialFileError: one of the participant's trial files is damaged.
    """
    files = [
        (path, file)
        for path in sorted((setup.recordings / CALIBRATION_FOLDER).glob(f"{setup.participant}-*.jsonl"))
        if (file := read_trials(path)).header.participant == setup.participant
    ]
    if not files:
        return None
    newest = max((file for _, file in files), key=lambda file: file.header.created_utc).header
    if newest.facts.get(PLANNED) != setup.planned:
        return None
    seed = newest.schedule.root_seed
    begun = {
        file.header.schedule.config.task: Part(file.header.schedule, path, done_trials(file))
        for path, file in files
        if file.header.schedule.root_seed == seed
    }
    parts = tuple(begun.get(config.task) or Part(make_schedule(config, seed)) for config in setup.configs)
    if all(part.complete for part in parts):
        return None
    age = datetime.fromisoformat(now_utc) - datetime.fromisoformat(newest.created_utc)
    return Unfinished(parts, seed, age / timedelta(hours=1))


def newest_complete(recordings: Path, task: Task, game: str = "tetris") -> Iterator[Path]:
    """Yield the newest finished session of each participant in this task, and in this game where one is
    watched.

    In a study each participant has a folder; `recordings` may be any of them.
    """
    found: dict[str, tuple[str, Path]] = {}
    name = slug(TaskConfig(task=task, game=game))
    folders = [folder / CALIBRATION_FOLDER for folder in group_folders(recordings)]
    for path in sorted(path for folder in folders for path in folder.glob(f"*-{name}-*.jsonl")):
        file = read_trials(path)
        header = file.header
        if (header.schedule.config.task, header.schedule.config.game) == (
            task,
            game,
        ) and file.next_trial >= len(header.schedule.trials):
            found[header.participant] = max(
                found.get(header.participant, ("", path)), (header.created_utc, path)
            )
    yield from (path for _, path in found.values())


def done_trials(file: TrialFile) -> frozenset[int]:
    """Return the trials that were finished."""
    return frozenset(record.trial for record in file.trials if not record.comment.startswith("abandoned"))
