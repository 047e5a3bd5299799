"""What `arl study status` prints, in lines of at most 80 columns."""

import textwrap
from collections.abc import Iterator, Sequence

from studies.lab.notes import Note
from studies.lab.status import Row, Status

COLUMNS = 80
INDENT = " " * 4


def status_lines(found: Status, notes: Sequence[Note], *, simulated: bool) -> Iterator[str]:
    """Yield the lines.

    Args:
        found: how far the study is.
        notes: of the experimenter.
        simulated: it is about simulated participants; the first line says so.
    """
    if simulated:
        yield "SIMULATED participants: none of these data are people's.\n"
    yield f"{found.finished} of {found.planned} have finished; {found.declined} did not consent.\n"
    for row in found.rows:
        yield from _row(row)
    yield "\nFinished with each order:"
    for order, count in found.orders:
        yield from _wrapped(f"  {count:3}  ", ", ".join(order))
    for note in notes:
        running = f" ({', '.join(note.running)})" if note.running else ""
        yield from _wrapped(f"Note of {note.at_utc}{running}: ", note.text, indent=INDENT)


def _row(row: Row) -> Iterator[str]:
    presses = "-" if row.presses_per_game is None else f"{row.presses_per_game:.1f}"
    where = "" if row.where == row.state else f"  {row.where}"
    yield from _wrapped(f"{row.code}  ", f"place {row.place + 1}, {row.state}{where}", indent=INDENT)
    minutes = "-" if row.minutes is None else f"{row.minutes:.0f}"
    yield f"{INDENT}{minutes} min, {row.games} games, {presses} presses a game"
    for flag in row.flags:
        yield from _wrapped(f"{INDENT}! ", flag, indent=INDENT + "  ")


def _wrapped(first: str, text: str, *, indent: str | None = None) -> list[str]:
    """Return a text in lines; a name that is longer than a line stays whole."""
    return textwrap.wrap(
        text,
        COLUMNS,
        initial_indent=first,
        subsequent_indent=" " * len(first) if indent is None else indent,
        break_long_words=False,
        break_on_hyphens=False,
    ) or [first]
