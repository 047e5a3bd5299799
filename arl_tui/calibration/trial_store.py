"""Trials on the disk, one file per task: every trial is there before the next one begins."""

from pathlib import Path

import msgspec

from arl_tui.calibration.plan import CalibrationSetup, Part, slug
from arl_tui.recordings import CALIBRATION_FOLDER, create_new
from core.numerics.clock import wall_time_utc
from studies.reaction_time.protocol import TrialRecord
from studies.reaction_time.trial_log import TrialHeader, TrialWriter


class TrialStore:
    """The files of a calibration."""

    def __init__(self, setup: CalibrationSetup) -> None:
        self.files: list[Path] = []
        """Files that have been written to."""
        self.complete: list[Path] = []
        """Files of tasks that went to their end, now or in an earlier part of the calibration."""
        self.trouble: str | None = None
        """Why nothing can be kept any more."""
        self._setup = setup
        self._writer: TrialWriter | None = None
        self._comment = ""

    @property
    def is_open(self) -> bool:
        """Whether trials can be kept now."""
        return self._writer is not None

    def open(self, part: Part, facts: dict[str, str]) -> None:
        """Begin a task's file, or go on with it.

        Args:
            part: the task.
            facts: how it is measured; goes into the header, where resumed a word of it into the next trial's
                comment.

        Raises:
            OSError: the disk does not take it.
            TrialFileError: the file to go on with is damaged.
        """
        if part.path is not None:
            self._writer, _ = TrialWriter.resume(part.path, despite_age=True)
            self._comment = f"resumed ({facts['connection']}, {facts.get('hindrances', 'no hindrance')})"
        else:
            folder = self._setup.recordings / CALIBRATION_FOLDER
            created_utc = wall_time_utc()
            name = f"{self._setup.participant}-{slug(part.schedule.config)}"
            header = TrialHeader(
                participant=self._setup.participant,
                created_utc=created_utc,
                schedule=part.schedule,
                facts=facts,
            )
            self._writer = create_new(
                folder, name, created_utc, lambda path: TrialWriter.create(path, header)
            )
        self.files.append(self._writer.path)

    def keep(self, record: TrialRecord, done: set[int]) -> bool:
        """Write a trial to the disk, and add it to those that are done; return whether that went well."""
        assert self._writer is not None, "a file is open while trials run"
        if self._comment:
            comment = "; ".join(part for part in (record.comment, self._comment) if part)
            record, self._comment = msgspec.structs.replace(record, comment=comment), ""
        try:
            self._writer.write(record)
        except OSError as error:
            self.trouble = f"The disk does not take the measurement: {error}"
            return False
        if not record.comment.startswith("abandoned"):
            done.add(record.trial)
        return True

    def close(self, *, finished: bool) -> None:
        """Close the task's file, if one is open.

        Args:
            finished: whether the task went to its end.
        """
        if self._writer is None:
            return
        if finished and self.trouble is None:
            self.complete.append(self._writer.path)
        self._writer.close()
        self._writer = None
