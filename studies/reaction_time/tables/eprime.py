"""E-Prime: the merged export of E-DataAid (a table behind a path) and log files of sessions.

Times are in milliseconds. An object called Stim writes Stim.RT, Stim.RESP, Stim.ACC and Stim.CRESP; without a
response RESP is empty and RT is 0. Where no response is right, CRESP is empty and ACC 1. Log files list
frames, a block's behind those of its trials; that of a session that crashed lacks the end, and then the
header tells the participant.
"""

import re
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from studies.reaction_time.tables.cells import Table
from studies.reaction_time.tables.contract import ReadError, shown
from studies.reaction_time.tables.numbers import is_missing
from studies.reaction_time.tables.plan import (
    Plan,
    Source,
    Trial,
    is_practice,
    is_right,
    participant_column,
    rt_column,
    scores,
)

_HEADER = "*** Header Start ***"
_PEOPLE = ("Subject", "Subject ID", "SubjectID")


class EPrime:
    """The merged export. See the module."""

    name = "eprime"
    title = "E-Prime"

    def marks(self, source: Source) -> str | None:
        """Return the marks of a log file, or the columns that only E-DataAid writes."""
        start = source.text.content[:4000]
        if _HEADER in start:
            return "'*** Header Start ***'"
        header = source.header
        times = any(name.endswith(".RT") for name in header)
        found: list[str] = [name for name in ("ExperimentName", "Subject", "Session") if name in header]
        found += [name for name in header if re.match(r"(Procedure|Running)\[", name)][:1]
        return ", ".join(map(shown, found)) if times and len(found) >= 2 and "Subject" in found else None

    def plan(self, source: Source, marks: str) -> Plan:
        """Take the rows in which the object that recorded the most responses was shown."""
        columns = source.columns
        log = _HEADER in source.text.content[:4000]
        table = _table_of_log(source.path, source.text.content) if log else source.table
        names = [name for name in table.header if name.endswith(".RT")]
        counts = {
            name: sum(not is_missing(v) and v != "0" for v in table.values(name).elements()) for name in names
        }
        rt = rt_column(table, columns, counts, self.title)
        scored, notes = scores(table, f"{rt.removesuffix('.RT')}.ACC")
        return Plan(
            table=table,
            recognised=f"E-Prime, {'log file' if log else 'merged export'}, by {marks}",
            rt=rt,
            unit=columns.unit or "ms",
            participant=participant_column(table, columns, _PEOPLE),
            judge=_judge(table, rt, scored=scored),
            notes=notes,
        )


def _judge(table: Table, rt: str, *, scored: bool) -> Callable[[Sequence[str]], Trial | str]:
    of = rt.removesuffix(".RT")
    time, answer, right, asked = (table.getter(f"{of}.{end}") for end in ("RT", "RESP", "ACC", "CRESP"))
    if not rt.endswith(".RT"):
        time = table.getter(rt)
    has_answers, has_asked = f"{of}.RESP" in table.header, f"{of}.CRESP" in table.header
    levels = [
        table.getter(name)
        for name in table.header
        if re.match(r"(Procedure|Running)(\[|$)|PracticeMode|Block$|BlockName", name)
    ]

    def judge(cells: Sequence[str]) -> Trial | str:
        practice = any(is_practice(get(cells)) for get in levels)
        if is_missing(time(cells)):
            return f"{shown(of)} was not shown in this row"
        if time(cells) in ("0", "0.0") and (answer(cells) == "" or not has_answers):
            withheld = has_asked and asked(cells) == "" and bool(is_right(right(cells)))
            return Trial(rt="", outcome="withheld" if withheld else "no response", practice=practice)
        wrong = scored and is_right(right(cells)) is False
        return Trial(rt=time(cells), outcome="wrong" if wrong else "response", practice=practice)

    return judge


# --- log files ----------------------------------------------------------------------------------------------


@dataclass
class _Frame:
    line: int
    level: int
    fields: dict[str, str] = field(default_factory=dict)


def _table_of_log(path: Path, text: str) -> Table:
    """Return the deepest level's frames as a table, with the fields of header and blocks beside them."""
    session: dict[str, str] = {}
    levels: list[str] = []
    notes: list[str] = []
    left_out: Counter[str] = Counter()
    trials: list[_Frame] = []
    frames = list(_frames(path, text, session, levels, notes, left_out))
    deepest = max((frame.level for frame in frames), default=0)
    since: dict[int, int] = {}
    for frame in frames:
        if frame.level == deepest:
            trials.append(frame)
            continue
        name = levels[frame.level - 1] if 0 < frame.level <= len(levels) else f"Level{frame.level}"
        for trial in trials[since.get(frame.level, 0) :]:  # A frame ends behind those that it holds.
            for key, value in frame.fields.items():
                trial.fields.setdefault(f"{key}[{name}]" if key in ("Procedure", "Running") else key, value)
        since.update(dict.fromkeys(range(frame.level, deepest), len(trials)))
        left_out[f"frames of {name}s (not of trials)"] += 1
    header = list(dict.fromkeys([*session, *(key for trial in trials for key in trial.fields)]))
    lines = [(t.line, [t.fields.get(name, session.get(name, "")) for name in header]) for t in trials]
    if not lines:
        raise ReadError(
            f"{path}: E-Prime's log file holds no whole frame: did the session end before its first trial?"
        )
    return Table(path, header, lines, left_out, notes)


def _frames(
    path: Path,
    text: str,
    session: dict[str, str],
    levels: list[str],
    notes: list[str],
    left_out: Counter[str],
) -> Iterator[_Frame]:
    frame: _Frame | None = None
    level, in_header, number = 1, False, 0
    for number, raw in enumerate(re.split(r"\r\n|\n|\r", text), start=1):
        line = raw.strip().lstrip("\ufeff")
        if line.startswith("***"):
            if "Header Start" in line or "Header End" in line:
                in_header = "Start" in line
            elif "LogFrame Start" in line:
                if frame is not None:
                    raise ReadError(
                        f"{path}:{number}: a frame begins inside the one of line {frame.line}: damaged?"
                    )
                frame = _Frame(number, level)
            elif "LogFrame End" in line and frame is not None:
                yield frame
                frame = None
            continue
        key, colon, value = line.partition(":")
        if not colon:
            continue
        if frame is not None:
            frame.fields[key] = value.strip()
        elif key == "Level":
            level = int(value) if value.strip().isdecimal() and len(value) < 4 else level
        elif in_header and key == "LevelName":
            levels.append(value.strip())
        elif in_header:
            session[key] = value.strip()
    if frame is not None:
        left_out["cut off in writing"] += 1
        notes.append(
            f"the file ends inside the frame that begins in line {frame.line}: the session stopped there, and"
            " that frame is left out"
        )
