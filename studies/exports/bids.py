"""A BIDS data set of a folder of data: events of each session, reaction trials, and what the columns mean.

Follows the Brain Imaging Data Structure, section "Behavioral experiments (with no neural recordings)". Dates
and texts that people typed are left out unless they are asked for.
"""

import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from importlib.metadata import version
from itertools import chain
from pathlib import Path
from typing import Any

from core.recording.reader import Recording, RecordingError, read_recording
from core.system.foreign_text import printable
from core.system.private_files import make_private_folder
from studies.exports.bids_pages import COLUMNS, HED, HED_VERSION, INSTRUCTIONS, README, TASKS, write_stimuli
from studies.exports.columns import Cell, Column, Row
from studies.exports.event_rows import press_rows, step_rows
from studies.exports.other_rows import trial_rows, trials_origin
from studies.exports.session_rows import SessionRows
from studies.exports.sources import Source, Trouble, find_sources
from studies.exports.tables import TRIALS
from studies.exports.tidy import ExportError
from studies.reaction_time.trial_log import TrialFile, TrialFileError, read_trials

BIDS_VERSION = "1.10.0"
NO_VALUE = "n/a"
_TRIAL_LEFT_OUT = frozenset({"participant", "session", "origin", "task", "domain"})
"""Columns of the tidy table that the name of a BIDS file says."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BidsSettings:
    """What is written."""

    name: str = "Key presses and reaction times"
    """Of the data set."""
    authors: tuple[str, ...] = ()
    """The validator expects two or more."""
    licence: str = ""
    """Such as CC0 or PDDL; empty: not said."""
    institution: str = ""
    institution_address: str = ""
    department: str = ""
    dates: bool = False
    """Write when sessions began (`_scans.tsv`)."""
    free_text: bool = False
    """Write remarks, and names of keys that mean nothing in the session."""


@dataclass(slots=True)
class BidsExport:
    """What came of it."""

    files: list[Path] = field(default_factory=list)
    """Data files that were written, below the data set's folder."""
    left_out: list[Trouble] = field(default_factory=list)
    """Files that BIDS has no place for."""
    damaged: list[Trouble] = field(default_factory=list)


@dataclass(slots=True)
class _Subject:
    origins: set[str] = field(default_factory=set)
    scans: list[tuple[str, str]] = field(default_factory=list)
    runs: dict[str, int] = field(default_factory=dict)


def export_bids(place: Path, into: Path, settings: BidsSettings | None = None) -> BidsExport:
    """Write a BIDS data set of the recordings and reaction trials in a folder.

    Args:
        place: a folder of data, or one file.
        into: a new or an empty folder.
        settings: what is written.

    Raises:
        ExportError: `into` is not empty, or two participants would get one label.
        OSError: something cannot be read or written.
    """
    if into.exists() and any(into.iterdir()):
        raise ExportError(f"{into} is not empty: name a new folder")
    writer = _Writer(into, settings or BidsSettings())
    for source in list(find_sources(place)):
        try:
            writer.add(source)
        except (RecordingError, TrialFileError) as error:
            writer.result.damaged.append(Trouble(source.path, str(error)))
    if not writer.result.files:
        raise ExportError(
            f"{place}: there is no recording and there are no reaction trials: nothing was written"
        )
    writer.finish()
    return writer.result


class _Writer:
    """Writes files of a data set, one source after the other."""

    def __init__(self, into: Path, settings: BidsSettings) -> None:
        self.into = into
        self.settings = settings
        self.result = BidsExport()
        self._subjects: dict[str, _Subject] = {}
        self._labels: dict[str, str] = {}
        self._tasks: dict[str, str] = {}
        """Suffix of the files of each task."""

    def add(self, source: Source) -> None:
        match source.kind:
            case "recording":
                self._session(read_recording(source.path))
            case "trials":
                self._trials(read_trials(source.path))
            case "sitting":
                said = "answers have no place in these files: `arl export tidy` writes them"
                self.result.left_out.append(Trouble(source.path, said))
            case _:
                self.result.left_out.append(Trouble(source.path, "no recording and no reaction trials"))

    def _session(self, recording: Recording) -> None:
        session = SessionRows(recording, "")
        header = recording.header
        subject, stem = self._named(header.participant, header.origin, session.game or "judging", "events")
        rows = sorted(
            chain(self._games(session), _steps(session), self._presses(session)), key=lambda row: _onset(row)
        )
        self._table(f"{stem}_events.tsv", COLUMNS, rows)
        system = header.terminal.get("system", "").partition(" ")[0]
        self._presentation(f"{stem}_events.json", header.software, system)
        subject.scans.append((f"beh/{Path(stem).name}_events.tsv", header.created_utc))

    def _trials(self, trials: TrialFile) -> None:
        task = re.sub(r"[^A-Za-z0-9]", "", trials.header.schedule.config.task)
        subject, stem = self._named(trials.header.participant, trials_origin(trials), task, "beh")
        self._table(f"{stem}_beh.tsv", self._trial_columns(), trial_rows(trials, ""))
        facts = trials.header.facts
        self._presentation(f"{stem}_beh.json", facts, facts.get("system", "").partition(" ")[0])
        subject.scans.append((f"beh/{Path(stem).name}_beh.tsv", trials.header.created_utc))

    def _trial_columns(self) -> tuple[Column, ...]:
        left_out = _TRIAL_LEFT_OUT | (frozenset() if self.settings.free_text else {"comment"})
        return tuple(column for column in TRIALS.columns if column.name not in left_out)

    def _named(self, code: str, origin: str, task: str, kind: str) -> tuple[_Subject, str]:
        """Return a participant and the beginning of their next file's name."""
        label = re.sub(r"[^A-Za-z0-9]", "", code)
        if not label or self._labels.setdefault(label, code) != code:
            raise ExportError(
                f"the participants {printable(code)} and {printable(self._labels.get(label, ''))} would both "
                f"be sub-{label}: "
                "BIDS labels are letters and digits. Give one of them another code (`arl anonymise`)"
            )
        subject = self._subjects.setdefault(label, _Subject())
        subject.origins.add(origin)
        subject.runs[task] = subject.runs.get(task, 0) + 1
        self._tasks[task] = kind
        return subject, f"sub-{label}/beh/sub-{label}_task-{task}_run-{subject.runs[task]:02}"

    def _games(self, session: SessionRows) -> Iterator[Row]:
        for row in session.game_rows():
            if row["watched"]:
                names = [
                    "game",
                    "performance",
                    "trust_before",
                    "trust_after",
                    "weight",
                    "condition",
                    "sitting",
                ]
                yield {
                    "onset": row["started_s"],
                    "duration": row["duration_s"],
                    "trial_type": "game",
                    **{name: row[name] for name in names},
                }

    def _presses(self, session: SessionRows) -> Iterator[Row]:
        names = [
            "game",
            "step",
            "condition",
            "sitting",
            "value",
            "judgement",
            "verdict",
            "counted",
            "retracted",
            "asked_wrong",
            "pressed_by",
            "key",
        ]
        for row in press_rows(session):
            said = {name: row[name] for name in names}
            if row["verdict"] == "other" and not self.settings.free_text:
                said["key"] = "other"
            yield {
                "onset": row["time_s"],
                "duration": 0.0,
                "trial_type": "press",
                "response_time": row["since_frame_s" if row["domain"] is None else "since_shown_s"],
                **said,
            }

    def _table(self, name: str, columns: Sequence[Column], rows: Iterable[Row]) -> None:
        path = self.into / name
        make_private_folder(path.parent)
        with path.open("x", encoding="utf-8", newline="") as file:
            file.write("\t".join(column.name for column in columns) + "\n")
            for row in rows:
                file.write("\t".join(_cell(row.get(column.name)) for column in columns) + "\n")
        self.result.files.append(Path(name))

    def _presentation(self, name: str, software: Mapping[str, str], system: str) -> None:
        said = {"SoftwareName": "arl-tui", "SoftwareVersion": software.get("arl-tui", "not recorded")}
        if system:
            said["OperatingSystem"] = system
        self._json(name, {"StimulusPresentation": said})

    def _json(self, name: str, content: Mapping[str, Any]) -> None:
        path = self.into / name
        make_private_folder(path.parent)
        text = json.dumps(content, indent=2, ensure_ascii=False)
        path.write_text(text + "\n", encoding="utf-8")

    def finish(self) -> None:
        """Write what describes the data set as a whole."""
        settings = self.settings
        said = {"License": settings.licence, "Authors": list(settings.authors)}
        description: dict[str, Any] = {
            "Name": settings.name,
            "BIDSVersion": BIDS_VERSION,
            "HEDVersion": HED_VERSION,
            "DatasetType": "raw",
            **{name: value for name, value in said.items() if value},
            "GeneratedBy": [
                {"Name": "arl-tui", "Version": version("arl-tui"), "Description": "arl export bids"}
            ],
            "SourceDatasets": [{"Version": "files of the formats arl-recording and arl-reaction-times"}],
        }
        self._json("dataset_description.json", description)
        (self.into / "README.md").write_text(README, encoding="utf-8")
        for task in sorted(self._tasks):
            is_game = self._tasks[task] == "events"
            columns = COLUMNS if is_game else self._trial_columns()
            kind = task if task in TASKS else "judging" if is_game else "trials"
            about = {"TaskName": task, "TaskDescription": TASKS[kind], "Instructions": INSTRUCTIONS[kind]}
            about |= self._institution()
            found = sidecar(columns)
            if is_game:
                found["trial_type"]["HED"] = HED
            self._json(f"task-{task}_{'events' if is_game else 'beh'}.json", {**about, **found})
        self._participants()
        write_stimuli(self.into / "stimuli", self._tasks)

    def _institution(self) -> dict[str, str]:
        settings = self.settings
        said = {
            "InstitutionName": settings.institution,
            "InstitutionAddress": settings.institution_address,
            "InstitutionalDepartmentName": settings.department,
        }
        return {name: value for name, value in said.items() if value}

    def _participants(self) -> None:
        columns = (
            Column("participant_id", "text", "Label of the participant."),
            Column("origin", "text", "Whether a real or a simulated participant pressed.", levels={
                "live": "a participant at a terminal",
                "simulated": "a simulated participant",
                "imported": "another program's log",
            }),
        )  # fmt: skip
        rows: list[Row] = [
            {"participant_id": f"sub-{label}", "origin": " ".join(sorted(subject.origins)) or None}
            for label, subject in sorted(self._subjects.items())
        ]
        self._table("participants.tsv", columns, rows)
        self._json("participants.json", sidecar(columns))
        if self.settings.dates:
            for label, subject in self._subjects.items():
                when = (Column("filename", "text", ""), Column("acq_time", "text", ""))
                scans: list[Row] = [
                    {"filename": name, "acq_time": _date(date)} for name, date in subject.scans
                ]
                self._table(f"sub-{label}/sub-{label}_scans.tsv", when, scans)


def _steps(session: SessionRows) -> Iterator[Row]:
    names = [
        "game",
        "step",
        "condition",
        "sitting",
        "piece",
        "action",
        "actor",
        "reward",
        "feedback",
        "presses_credited",
    ]
    for row in step_rows(session):
        shown = row["shown_s"] is not None
        yield {
            "onset": row["shown_s"] if shown else row["decided_s"],
            "duration": row["on_screen_s"] if shown else None,
            "trial_type": "step",
            "stim_file": _stimulus(session.game, row),
            **{name: row[name] for name in names},
        }


def _stimulus(game: str, row: Row) -> str | None:
    """Return the drawing of what a step showed; a piece as it comes where its orientation is not recorded."""
    if game == "keepaway":
        return "keepaway.txt"
    return f"tetris/{row['piece']}-{row['orientation'] or 1}.txt" if row["piece"] else None


def _onset(row: Row) -> float:
    onset = row["onset"]
    assert isinstance(onset, float), "an event has a time"
    return onset


def sidecar(columns: Iterable[Column]) -> dict[str, Any]:
    """Return what a JSON sidecar says of columns: description, units, levels."""
    found: dict[str, Any] = {}
    for column in columns:
        said: dict[str, Any] = {"Description": column.meaning}
        if column.unit:
            said["Units"] = column.unit
        if column.kind == "boolean":
            said["Levels"] = {"true": "yes", "false": "no"}
        elif column.levels:
            said["Levels"] = {level: meaning or level for level, meaning in column.levels.items()}
        found[column.name] = said
    return found


def _cell(cell: Cell) -> str:
    if cell is None or cell == "":
        return NO_VALUE
    if isinstance(cell, bool):
        return "true" if cell else "false"
    return printable(cell, longest=None) if isinstance(cell, str) else repr(cell)


def _date(date: str) -> str | None:
    """Return a date as BIDS writes it; None for one that was removed."""
    return date.partition("+")[0] if re.match(r"\d{4}-", date) else None
