"""jsPsych's data, CSV or JSON: a row per trial of any plugin, times in milliseconds.

Without a response the time is null (before version 6: -1).

A session holds instructions, fixations, surveys and the trials themselves. Trials are told from the rest by
what the experimenter wrote beside them: a column such as `task` that names the parts, and whether parts are
scored (`correct`).
"""

import json
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
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

_MARKS = ("trial_type", "trial_index", "time_elapsed", "internal_node_id", "plugin_version")
_PEOPLE = (
    "participant",
    "subject",
    "subject_id",
    "participantID",
    "subjectID",
    "PROLIFIC_PID",
    "prolific_id",
    "worker_id",
    "workerId",
    "ppt",
    "run_id",
    "(data set)",
)
_PARTS = (
    "task",
    "test_part",
    "trial_part",
    "phase",
    "part",
    "screen",
    "screen_id",
    "trial_name",
    "event",
    "name",
)
"""Columns in which experimenters say what a row is; the first that is there counts."""
_NOT_TRIALS = (
    "instr",
    "consent",
    "debrief",
    "welcome",
    "intro",
    "feedback",
    "thank",
    "goodbye",
    "end",
    "fixation",
)
_NO_REACTIONS = (
    "survey",
    "instructions",
    "fullscreen",
    "preload",
    "call-function",
    "external-html",
    "browser-check",
    "virtual-chinrest",
    "initialize-",
    "webgazer",
    "mirror-camera",
    "resize",
    "cloze",
    "free-sort",
    "maxdiff",
    "sketchpad",
    "consent",
    "pause",
)
"""Beginnings of the names of plugins that measure no reaction; any other plugin (also one's own) may."""
_MOST_PARTS = 12
_OFTEN = 3


class JsPsych:
    """See the module."""

    name = "jspsych"
    title = "jsPsych"

    def marks(self, source: Source) -> str | None:
        """Return the columns that only jsPsych writes."""
        text = source.text.content.lstrip()
        if text[:1] in ("[", "{"):
            return "its JSON's trial_type and rt" if '"trial_type"' in text and '"rt"' in text else None
        found = [name for name in _MARKS if name in source.header]
        return ", ".join(map(shown, found)) if len(found) >= 2 and "rt" in source.header else None

    def plan(self, source: Source, marks: str) -> Plan:
        """Take the trials of plugins that measure reactions, of the parts that are scored if any are."""
        text = source.text.content.lstrip()
        table = _table_of_json(source.path, text) if text[:1] in ("[", "{") else source.table
        columns = source.columns
        scored, notes = scores(table, "correct")
        rt = rt_column(table, columns, {"rt": len(table.lines)}, self.title)
        return Plan(
            table=table,
            recognised=f"jsPsych, by {marks}",
            rt=rt,
            unit=columns.unit or "ms",
            participant=participant_column(table, columns, _PEOPLE),
            judge=_judge(table, rt, scored=scored, chosen=bool(columns.keep)),
            notes=notes,
        )


def _judge(table: Table, rt: str, *, scored: bool, chosen: bool) -> Callable[[Sequence[str]], Trial | str]:
    time, plugin, right = table.getter(rt), table.getter("trial_type"), table.getter("correct")
    flags = [table.getter(name) for name in ("practice", "is_practice") if name in table.header]
    parts = [table.getter(name) for name in (*_PARTS, "block", "block_type") if name in table.header]
    aside = None if chosen else _aside(table, time, right, scored=scored)

    def judge(cells: Sequence[str]) -> Trial | str:
        if not _measures_reactions(plugin(cells)):
            return f"trial_type {shown(plugin(cells))}: measures no reaction"
        reason = aside(cells) if aside is not None else None
        if reason is not None:
            return reason
        practice = any(is_right(get(cells)) for get in flags) or any(is_practice(get(cells)) for get in parts)
        if is_missing(time(cells)) or time(cells) in ("-1", "-1.0"):
            withheld = scored and is_right(right(cells)) is True
            return Trial(rt="", outcome="withheld" if withheld else "no response", practice=practice)
        wrong = scored and is_right(right(cells)) is False
        return Trial(rt=time(cells), outcome="wrong" if wrong else "response", practice=practice)

    return judge


def _measures_reactions(plugin: str) -> bool:
    return not plugin.lower().removeprefix("jspsych-").startswith(_NO_REACTIONS)


def _aside(
    table: Table,
    time: Callable[[Sequence[str]], str],
    right: Callable[[Sequence[str]], str],
    *,
    scored: bool,
) -> Callable[[Sequence[str]], str | None]:
    """Return a function that says why a row is no trial of the experiment; None if it is one."""
    few = max(_MOST_PARTS, len(table.lines) // 10)
    part = next((n for n in _PARTS if n in table.header and 1 < len(table.values(n)) <= few), None)
    if part is None:
        return _by_stimulus(table, time)
    get = table.getter(part)
    answered = {get(cells) for _, cells in table.lines if not is_missing(time(cells))}
    judged = (
        {get(cells) for _, cells in table.lines if is_right(right(cells)) is not None} if scored else set()
    )

    def reason(cells: Sequence[str]) -> str | None:
        value = get(cells)
        if value not in answered:
            return f"{part} {shown(value)}: never has a response"
        if (judged and value not in judged) or value.lower().startswith(_NOT_TRIALS):
            return f"{part} {shown(value)}: not scored" if judged else f"{part} {shown(value)}"
        return None

    return reason


def _by_stimulus(table: Table, time: Callable[[Sequence[str]], str]) -> Callable[[Sequence[str]], str | None]:
    """Tell fixations from missed trials: stimuli that come often and never have a response."""
    stimulus = table.getter("stimulus")
    answered = {stimulus(cells) for _, cells in table.lines if not is_missing(time(cells))}
    often = Counter(stimulus(cells) for _, cells in table.lines)

    def reason(cells: Sequence[str]) -> str | None:
        value = stimulus(cells)
        if value not in answered and (often[value] >= _OFTEN or not value):
            return "stimuli that come often and never have a response (fixations)"
        return None

    return reason


# --- JSON ---------------------------------------------------------------------------------------------------


def _table_of_json(path: Path, text: str) -> Table:
    """Return the trials of one or several JSON arrays (JATOS and others write one for each session)."""
    sets = list(_data_sets(path, text))
    many = len(sets) > 1
    names = list(dict.fromkeys(key for trials in sets for _, trial in trials for key in trial))
    header = [*names, "(data set)"] if many else names
    lines = [
        (number, [*(_text(trial.get(name)) for name in names), *([str(at)] if many else [])])
        for at, trials in enumerate(sets, start=1)
        for number, trial in trials
    ]
    if not lines:
        raise ReadError(f"{path}: the JSON holds no trial")
    notes = [f"{len(sets)} sessions in one file, numbered in its order"] if many else []
    return Table(path, header, lines, notes=notes)


def _data_sets(path: Path, text: str) -> Iterator[list[tuple[int, dict[str, object]]]]:
    decoder = json.JSONDecoder()
    at = 0
    while at < len(text):
        if text[at].isspace() or text[at] in ",\ufeff":
            at += 1
            continue
        try:
            value, end = decoder.raw_decode(text, at)
        except (ValueError, RecursionError) as error:
            where = at + (error.pos - at if isinstance(error, json.JSONDecodeError) else 0)
            line = text.count("\n", 0, where) + 1
            raise ReadError(
                f"{path}:{line}: not whole JSON ({error}). Was the file cut off? The data before it are in"
                " the file, but only a person can tell where they end"
            ) from error
        line = text.count("\n", 0, at) + 1
        yield from _sessions(path, line, value)
        at = end


def _sessions(path: Path, line: int, value: object) -> Iterator[list[tuple[int, dict[str, object]]]]:
    """Yield lists of trials from an array, an array of arrays, or an object that holds one of them."""
    if isinstance(value, dict) and "trial_type" not in value:
        inner = [
            entry
            for key, entry in value.items()
            if key in ("trials", "data", "values") and isinstance(entry, list)
        ]
        if len(inner) != 1:
            raise ReadError(
                f"{path}:{line}: expected an array of jsPsych's trials, got an object with {len(value)}"
                " fields"
            )
        value = inner[0]
    trials = [value] if isinstance(value, dict) else value
    if not isinstance(trials, list):
        raise ReadError(f"{path}:{line}: expected an array of jsPsych's trials, got {shown(str(value)[:40])}")
    if trials and all(isinstance(entry, list) for entry in trials):
        for entry in trials:
            yield from _sessions(path, line, entry)
        return
    flat = [entry for entry in trials if isinstance(entry, dict)]
    if len(flat) != len(trials):
        raise ReadError(
            f"{path}:{line}: {len(trials) - len(flat)} entries of the array are no trials (no objects)"
        )
    yield [(number, entry) for number, entry in enumerate(flat, start=1)]


def _text(value: object) -> str:
    if value is None:
        return ""
    if isinstance(value, str):
        return value
    return json.dumps(value, ensure_ascii=False)
