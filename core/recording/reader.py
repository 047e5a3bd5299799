"""Read a recording back, check every line, and say exactly where one is wrong."""

from dataclasses import dataclass
from pathlib import Path

import msgspec

from core.episode import Event, Input, Output
from core.recording.recorder import CHAIN_DIGITS, Chain
from core.recording.schema import FORMAT, End, Header, Line

CHAIN_MARK = b',"chain":"'

_decoder = msgspec.json.Decoder(Line)


class RecordingError(Exception):
    """A recording cannot be used; the message says where, what came, what was expected, what to do."""


@dataclass(frozen=True, slots=True)
class Recording:
    """A recording in memory: checked, in the order of the file."""

    path: Path
    header: Header
    events: tuple[Event, ...]
    complete: bool
    """False when the session was cut off: there is no end line."""
    lost_tail: bytes = b""
    """What stands behind the last whole line: the one that was being written when the session was cut off."""

    @property
    def inputs(self) -> tuple[Input, ...]:
        """What the screen showed and the participant did, in order."""
        return tuple(event for event in self.events if isinstance(event, Input))

    @property
    def outputs(self) -> tuple[Output, ...]:
        """What the domain and the agent did, in order."""
        return tuple(event for event in self.events if isinstance(event, Output))


def read_recording(path: Path, *, allow_truncated: bool = True) -> Recording:
    """Read and check a recording.

    Args:
        path: a `.jsonl` file.
        allow_truncated: take a file without an end line (a session that was cut off) for what it holds.

    Raises:
        RecordingError: the file is not a recording, a line is damaged, or it is cut off and must not be.
        OSError: the file cannot be read.
    """
    content = path.read_bytes()
    whole, newline, tail = content.rpartition(b"\n")
    lines = whole.split(b"\n") if newline else []
    if not lines:
        raise RecordingError(f"{path}: not a recording: it holds no whole line")
    chain = Chain()
    header = _decode(path, 1, lines[0], chain)
    if not isinstance(header, Header):
        raise RecordingError(f"{path}:1: the first line is of type {header!r}; expected a {FORMAT} header")
    events: list[Event] = []
    end: End | None = None
    for number, line in enumerate(lines[1:], start=2):
        if end is not None:
            raise RecordingError(
                f"{path}:{number}: there is a line behind the end line; was something appended?"
            )
        record = _decode(path, number, line, chain)
        if isinstance(record, Header):
            raise RecordingError(f"{path}:{number}: a second header; were two files joined?")
        if isinstance(record, End):
            end = record
        else:
            events.append(record)
    _check_end(path, len(lines), events, end, allow_truncated=allow_truncated)
    return Recording(path, header, tuple(events), complete=end is not None, lost_tail=tail)


def _decode(path: Path, number: int, line: bytes, chain: Chain) -> Line:
    payload, mark, rest = line.rpartition(CHAIN_MARK)
    if not mark or len(rest) != CHAIN_DIGITS + 2 or not rest.endswith(b'"}'):
        raise RecordingError(
            f"{path}:{number}: the line does not end with its chain; found {line[-40:]!r}. "
            "Was the file edited, or is it not a recording?"
        )
    payload += b"}"
    if chain.advance(payload) != rest[:CHAIN_DIGITS]:
        raise RecordingError(
            f"{path}:{number}: the line's chain does not follow from the lines before it: "
            "this line was changed, or one before it was changed, removed or moved"
        )
    try:
        line_read: Line = _decoder.decode(payload)
    except (msgspec.DecodeError, ValueError) as error:
        raise RecordingError(f"{path}:{number}: {error}; the line begins {payload[:80]!r}") from error
    return line_read


def _check_end(
    path: Path, n_lines: int, events: list[Event], end: End | None, *, allow_truncated: bool
) -> None:
    if end is None and not allow_truncated:
        raise RecordingError(
            f"{path}:{n_lines}: no end line; the session stopped after {len(events)} events. "
            "Use `--allow-truncated` to take what is there."
        )
    if end is not None and end.events != len(events):
        raise RecordingError(
            f"{path}:{n_lines}: the end line counts {end.events} events, the file holds {len(events)}"
        )
