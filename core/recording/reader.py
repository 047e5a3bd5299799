"""Read a recording back, check every line, and say exactly where one is wrong."""

from dataclasses import dataclass
from pathlib import Path

import msgspec

from core.episode import Event, Input, Output
from core.recording import version_1
from core.recording.recorder import CHAIN_DIGITS, Chain
from core.recording.schema import FORMAT, VERSION, End, Header, Line, not_readable

CHAIN_MARK = b',"chain":"'

_decoder = msgspec.json.Decoder(Line)
_decoder_1 = msgspec.json.Decoder(version_1.Changed)


class _Kind(msgspec.Struct):
    """What has to be known of a line before it is decoded."""

    type: str = ""
    version: object = VERSION


class RecordingError(Exception):
    """A recording cannot be used; the message says where, what came, what was expected, what to do."""


@dataclass(frozen=True, slots=True)
class Recording:
    """A recording in memory: checked, in the order of the file. Events of version 1 are today's (`core.recording.version_1`)."""

    path: Path
    header: Header
    """As in the file, its protocol as today's program understands it."""
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
    header = _decode(path, 1, lines[0], chain, VERSION)
    if not isinstance(header, Header):
        raise RecordingError(f"{path}:1: the first line is of type {header!r}; expected a {FORMAT} header")
    events: list[Event] = []
    end: End | None = None
    for number, line in enumerate(lines[1:], start=2):
        if end is not None:
            raise RecordingError(
                f"{path}:{number}: there is a line behind the end line; was something appended?"
            )
        record = _decode(path, number, line, chain, header.version)
        if isinstance(record, Header):
            raise RecordingError(f"{path}:{number}: a second header; were two files joined?")
        if isinstance(record, End):
            end = record
        else:
            events.append(record)
    _check_end(path, len(lines), events, end, allow_truncated=allow_truncated)
    if header.version == 1:
        header = msgspec.structs.replace(header, protocol=version_1.with_schedules(header.protocol))
    return Recording(path, header, tuple(events), complete=end is not None, lost_tail=tail)


def _decode(path: Path, number: int, line: bytes, chain: Chain, version: int) -> Line:
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
        return _record(payload, version)
    except (msgspec.DecodeError, ValueError) as error:
        raise RecordingError(f"{path}:{number}: {error}; the line begins {payload[:80]!r}") from error


def _record(payload: bytes, version: int) -> Line:
    """Return what a line says, in today's terms.

    Raises:
        ValueError: it is none of this version (`msgspec.ValidationError` where a field is wrong).
    """
    kind = msgspec.json.decode(payload, type=_Kind)
    if kind.type == "header" and not (isinstance(kind.version, int) and 1 <= kind.version <= VERSION):
        raise ValueError(not_readable(kind.version))
    changed = kind.type in version_1.CHANGED_TAGS
    if version == 1 and changed:
        before: version_1.Changed = _decoder_1.decode(payload)
        return before.upgraded()
    try:
        record: Line = _decoder.decode(payload)
    except msgspec.ValidationError as error:
        if changed and kind.type != "session-ended" and b'"w_h":' in payload:
            raise ValueError(
                f"{error}: this {kind.type} is of version 1 of the format (it says `w_h`), and the header says version "
                f"{version} (`trust`, `weight`): the header was changed, or two files were joined"
            ) from error
        raise
    return record


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
