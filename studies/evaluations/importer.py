"""Turn tables of evaluations into recordings: presses and the events they judge, without boards or actions.

Such a recording gives delays (`arl fit`), bursts and reports (`arl presses`). It gives no replay: what the
agent saw and did is not in it. Times begin at 0 in each recording, because a table's clock often is the
wall's.
"""

import hashlib
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from core.events import Event, FrameShown, KeyPressed, SessionEnded
from core.numerics.clock import wall_time_utc
from core.recording.importers.contract import Imported, ImporterError
from core.recording.recorder import write_recording
from core.recording.schema import Header
from core.system.foreign_text import printable
from studies.evaluations.table import Evaluation, EvaluationColumns, EvaluationTable, read_evaluations

FORMAT = "evaluations"
"""`Header.source["format"]` of these recordings."""


class Evaluations:
    """The importer (`core.recording.importers.contract`)."""

    name = FORMAT
    summary = "A table of evaluations of an agent: participant, time, value, delay."
    settings: Mapping[str, str] = {
        "participant": "column of the participant's code; participant_id without it",
        "time": "column of the time of the press; time_s without it",
        "value": "column of the value (> 0 good, < 0 bad); value without it",
        "delay": "column of the time since the event judged; delay_s without it, if there",
        "by": "columns, joined by commas, whose values make recordings of their own",
        "unit": "unit of the times: s, ms, us, ns; by the columns' names without it",
        "encoding": "code page of the table",
    }

    def run(self, source: Path, folder: Path, settings: Mapping[str, str]) -> Imported:
        """Write one recording per participant, and per value of the `by` columns, into a folder."""
        given = {key: text for key, text in settings.items() if key != "by"}
        by = tuple(name for name in settings.get("by", "").split(",") if name)
        table = read_evaluations(source, EvaluationColumns(**given, by=by))
        targets = {key: folder / f"{_file_name(key)}.jsonl" for key in table.sessions}
        if len(set(targets.values())) < len(targets):
            raise ImporterError(
                f"{source}: different values of {', '.join(by)} make the same file name; rename some"
            )
        for target in targets.values():
            if target.exists():
                raise FileExistsError(
                    f"{target} exists: recordings are never overwritten; name another folder (--out)"
                )
        digest = hashlib.sha256(source.read_bytes()).hexdigest()
        for key, session in table.sessions.items():
            _write(targets[key], source, digest, by, key, session)
        return Imported(recordings=tuple(targets.values()), lines=tuple(_lines(table)))


IMPORTER = Evaluations()


def _file_name(key: Sequence[str]) -> str:
    return "-".join(re.sub(r"[^A-Za-z0-9_]+", "-", part).strip("-")[:40] or "none" for part in key)


def _write(
    target: Path,
    source: Path,
    digest: str,
    by: Sequence[str],
    key: Sequence[str],
    session: Sequence[Evaluation],
) -> None:
    conditions = {f"condition {name}": value for name, value in zip(by, key[1:], strict=True)}
    header = Header(
        origin="imported",
        created_utc=wall_time_utc(),
        clock="that of the table, from 0 at the recording's first event",
        clock_resolution_ns=1,
        started_ns=0,
        participant=key[0],
        root_seed=0,
        protocol={},
        software={},
        departures=[
            (
                "imported: presses, values and delays are those of the source; each frame is the event that a"
                " press judges"
            ),
            "what the agent saw and did is not in the source: nothing can be replayed",
        ],
        source={"format": FORMAT, "file": printable(source.name), "sha256": digest, **conditions},
    )
    write_recording(target, header, _events(session))


def _events(session: Sequence[Evaluation]) -> Iterator[Event]:
    """Yield frames and presses in the order of their times, from 0, and the end."""
    begin = min(one.time_ns - max(one.delay_ns or 0, 0) for one in session)
    keyed: list[tuple[int, int, int, Event]] = []
    frame = -1
    for press, one in enumerate(session):
        time_ns = one.time_ns - begin
        if one.delay_ns is not None:
            frame += 1
            shown_ns = time_ns - one.delay_ns
            keyed.append((shown_ns, 0, press, FrameShown(frame=frame, step=-1, flushed_ns=shown_ns)))
        pressed = KeyPressed(
            press=press,
            time_ns=time_ns,
            key=f"{one.value:+g}",
            value=one.value,
            frame=frame if one.delay_ns is not None else -1,
            step=-1,
            verdict="accepted",
        )
        keyed.append((time_ns, 1, press, pressed))
    keyed.sort(key=lambda entry: entry[:3])
    yield from (event for *_, event in keyed)
    yield SessionEnded(
        time_ns=keyed[-1][0], inputs=len(keyed), reason="end of the table", weights={}, digest=""
    )


def _lines(table: EvaluationTable) -> Iterator[str]:
    n = sum(len(session) for session in table.sessions.values())
    people = len({key[0] for key in table.sessions})
    yield f"{n} evaluations of {people} participants in {len(table.sessions)} recordings"
    missing = sum(one.delay_ns is None for session in table.sessions.values() for one in session)
    if not table.has_delays:
        yield "no column of delays: bursts and values only (--column delay=NAME)"
    elif missing:
        yield f"{missing} of them without a delay: kept as presses"
    early = sum((one.delay_ns or 0) < 0 for session in table.sessions.values() for one in session)
    if early:
        yield f"{early} came before the event that they judge (a negative delay): kept"
    if table.out_of_order:
        yield f"sorted: {table.out_of_order} rows stood behind a later one"
    for reason, count in table.left_out.items():
        yield f"left out: {count} rows, {reason}"
    yield from (f"note: {note}" for note in table.notes)
