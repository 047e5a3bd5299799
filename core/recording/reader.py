"""Read a recording back, check every line, and say exactly where one is wrong."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec

from core.events import Event, Input, Output
from core.recording import version_1
from core.recording.chain import CHAIN_DIGITS, Chain
from core.recording.lines import CHAIN_MARK, record_of
from core.recording.schema import FORMAT, VERSION, End, Header, Line
from core.recording.undo import RecordingError, as_recorded
from core.system.bounded_read import read_bounded
from core.system.in_use import is_held

__all__ = ["Recording", "RecordingError", "read_recording"]

_HEADER_MARK = b'{"type":"header"'
_VERSION_SAID = re.compile(rb'"version":\d+')
TAKE_THE_ORIGINAL = "Take the unchanged file, from a backup or from where it was copied"

LONGEST_LINE = 1 << 26
"""Bytes of a line. The longest of a session is the one with all that was learned, some megabytes of
weights."""


@dataclass(frozen=True, slots=True)
class Recording:
    """A recording in memory: checked, in the order of the file.

    Events of version 1 are today's (`core.recording.version_1`).
    """

    path: Path
    header: Header
    """As in the file, its protocol as today's program understands it."""
    events: tuple[Event, ...]
    complete: bool
    """False when the session was cut off: there is no end line."""
    lost_tail: bytes = b""
    """What stands behind the last whole line: the one that was being written when the session was cut off."""
    notes: tuple[str, ...] = ()
    """What is unusual about the file and was put right while reading, in plain sentences."""
    chain: str = ""
    """Chain of the last whole line, hex: no other content has the same."""
    older: tuple[Path, ...] = ()
    """Older recordings whose events come first, where a session was resumed (`core.recording.joined`)."""
    empty_lines: tuple[int, ...] = ()
    """Numbers of the lines that hold nothing, from 1, ascending."""
    signature: str = ""
    """In the end line, hex; "" where there is none."""
    being_written: bool = False
    """Whether a program on this computer is writing it now; `complete` is False then."""
    signed: bytes = b""
    """What the signature is about (`core.recording.chain.Chain.to_sign`)."""

    def line_of(self, index: int) -> int:
        """Return the number of the line, from 1, on which event number `index`, from 0, stands."""
        line = index + 2
        for empty in self.empty_lines:
            line += empty <= line
        return line

    @property
    def inputs(self) -> tuple[Input, ...]:
        """What the screen showed and the participant did, in order."""
        return tuple(event for event in self.events if isinstance(event, Input))

    @property
    def outputs(self) -> tuple[Output, ...]:
        """What the domain and the agent did, in order."""
        return tuple(event for event in self.events if isinstance(event, Output))

    @property
    def n_outputs(self) -> int:
        """How many outputs there are."""
        return sum(isinstance(event, Output) for event in self.events)

    @property
    def last_output(self) -> Output | None:
        """The last output; None where there is none."""
        return next((event for event in reversed(self.events) if isinstance(event, Output)), None)


def read_recording(path: Path, *, allow_truncated: bool = True) -> Recording:
    """Read and check a recording.

    A file that was compressed, or whose line ends or encoding were changed, is read as it was recorded, where
    its chain is then whole; `Recording.notes` says so.

    Args:
        path: a `.jsonl` file, or one compressed by gzip, bzip2 or xz.
        allow_truncated: take a file without an end line (a session that was cut off) for what it holds.

    Raises:
        RecordingError: the file is not a recording, a line is damaged, or it is cut off and must not be.
        OSError: the file cannot be read.
    """
    if path.is_dir():
        raise RecordingError(
            f"{path}: a folder, not a recording: name a file in it, or list them: `arl recordings`"
        )
    found = as_recorded(path, read_bounded(path))
    reading, undone = _Reading(path, found.content, list(found.notes)), found.notes
    del found  # the content of a long session is let go while it is read
    try:
        return reading.read(allow_truncated=allow_truncated)
    except RecordingError as error:
        if not undone:
            raise
        raise RecordingError(f"{error} (Besides, {'; '.join(undone)}.)") from error


class _Reading:
    """Reads one file, line by line."""

    def __init__(self, path: Path, content: bytes, notes: list[str]) -> None:
        self._path = path
        self._content = content
        self._notes = notes
        self._chain = Chain()
        self._last_chain = ""
        self._blank: tuple[int, ...] = ()  # numbers of empty lines, ascending
        self._numbers: list[int] = []  # of the other lines, where there are empty ones
        self._n_line_ends = 0

    def read(self, *, allow_truncated: bool) -> Recording:
        lines, tail = self._lines()
        n_lines = len(lines)
        # From the last to the first, so that each can be let go when it has been read.
        lines.reverse()
        header = self._header(lines.pop())
        events: list[Event] = []
        end: End | None = None
        signed = b""
        while lines:
            number = self._number(n_lines - len(lines))
            if end is not None:
                raise self._wrong(
                    number,
                    "there is a line behind the end line; was something appended? Keep the first "
                    f"{number - 1} lines",
                )
            signed = b"" if len(lines) > 1 else self._chain.to_sign(len(events))
            record = self._decode(number, lines.pop(), header.version)
            assert not isinstance(record, Header), "a second header was looked for before"
            if isinstance(record, End):
                end = record
            else:
                events.append(record)
        tail = self._about_tail(tail, end)
        self._check_end(self._number(n_lines - 1), events, end, allow_truncated=allow_truncated)
        if header.version == 1:
            header = msgspec.structs.replace(header, protocol=version_1.with_schedules(header.protocol))
        return Recording(
            self._path,
            header,
            tuple(events),
            end is not None,
            tail,
            tuple(self._notes),
            empty_lines=self._blank,
            signature="" if end is None else end.signature,
            signed=signed,
            chain=self._last_chain,
            being_written=end is None and is_held(self._path),
        )

    def _wrong(self, number: int, what: str) -> RecordingError:
        return RecordingError(f"{self._path}:{number}: {what}")

    def _number(self, place: int) -> int:
        """Return the number, from 1, of a line that is not empty, by its place among those, from 0."""
        return self._numbers[place] if self._numbers else place + 1

    def _lines(self) -> tuple[list[bytes], bytes]:
        """Return the whole lines that are not empty, and what stands behind the last one."""
        self._check_lengths()
        self._n_line_ends = self._content.count(b"\n")
        lines = self._content.split(b"\n")
        tail = lines.pop()
        if tail.endswith(b'"}') and CHAIN_MARK in tail[-CHAIN_DIGITS - 16 :]:
            # A whole line; if it is not, its chain says so.
            self._notes.append(
                "the line end behind the last line is missing; an editor may have taken it away"
            )
            lines.append(tail)
            tail = b""
        self._blank = tuple(number for number, line in enumerate(lines, start=1) if not line.strip())
        if self._blank:
            self._notes.append(f"{_these_lines(self._blank)} empty, which no recording is; left out")
            self._numbers = [number for number, line in enumerate(lines, start=1) if line.strip()]
            lines = [line for line in lines if line.strip()]
        if not lines:
            raise self._wrong(1, self._no_line())
        self._content = b""
        return self._once(lines), tail

    def _check_lengths(self) -> None:
        """Refuse a line that no session writes before it is copied."""
        if len(self._content) <= LONGEST_LINE:
            return
        start, number = 0, 1
        while start < len(self._content):
            end = self._content.find(b"\n", start)
            end = len(self._content) if end < 0 else end
            if end - start > LONGEST_LINE:
                raise self._wrong(
                    number,
                    f"a line of {end - start:,} bytes; a session writes none of more than {LONGEST_LINE:,}. "
                    f"{TAKE_THE_ORIGINAL}",
                )
            start, number = end + 1, number + 1

    def _no_line(self) -> str:
        if self._content.startswith(_HEADER_MARK):
            return (
                f"cut off within the header, after {len(self._content)} bytes: no event is in the file. "
                f"{TAKE_THE_ORIGINAL}"
            )
        return f"not a recording: it holds no whole line. {_looks_like(self._content)}"

    def _once(self, texts: list[bytes]) -> list[bytes]:
        """Return the lines of the first copy where a file holds the same recording several times."""
        second = next((n for n, text in enumerate(texts) if n and text.startswith(_HEADER_MARK)), None)
        if second is None:
            return texts
        number = self._number(second)
        if all(text == texts[n % second] for n, text in enumerate(texts)):
            times = "twice" if len(texts) == 2 * second else f"{len(texts) / second:.1f} times"
            self._notes.append(
                f"the file holds the same recording {times} (joined or appended); it was read once: "
                f"lines 1 to {number - 1}"
            )
            return texts[:second]
        raise self._wrong(
            number,
            "a second header: two recordings were joined. Split them before this line: `head -n "
            f"{number - 1}` and `tail -n +{number}` give one each",
        )

    def _header(self, line: bytes) -> Header:
        plain = _plain(line)
        if not isinstance(plain, Mapping) or plain.get("type") != "header" or plain.get("format") != FORMAT:
            raise self._wrong(
                1, f"not a recording: its first line is no {FORMAT} header. {_looks_like(line)}"
            )
        version = plain.get("version")
        if isinstance(version, int) and version > VERSION:
            software = plain.get("software")
            by = software.get("arl-tui") if isinstance(software, Mapping) else None
            raise self._wrong(
                1,
                f"version {version} of the format, newer than this program, which reads up to version "
                f"{VERSION}. "
                f"It was written by arl-tui {by or 'of a later version'}: update this program",
            )
        missing = [name for name in ("created_utc", "participant") if name not in plain]
        if missing:
            raise self._wrong(
                1,
                f"the header was changed after it was recorded: {' and '.join(missing)} was taken out, and "
                f"the chain cannot be checked any more. {TAKE_THE_ORIGINAL}; `arl recordings --publish DIR` "
                "makes copies without dates",
            )
        header = self._decode(1, line, VERSION)
        assert isinstance(header, Header), "its type was looked at"
        return header

    def _decode(self, number: int, line: bytes, version: int) -> Line:
        payload, mark, rest = line.rpartition(CHAIN_MARK)
        if not mark or len(rest) != CHAIN_DIGITS + 2 or not rest.endswith(b'"}'):
            raise self._wrong(
                number,
                f"the line does not end with its chain; found {line[-40:]!r}. It was edited or cut. "
                f"{TAKE_THE_ORIGINAL}",
            )
        payload += b"}"
        if self._chain.advance(payload) != rest[:CHAIN_DIGITS]:
            raise self._wrong(number, _broken(number, payload, rest[:CHAIN_DIGITS]))
        self._last_chain = rest[:CHAIN_DIGITS].decode()
        try:
            return record_of(payload, version)
        except RecursionError as error:
            raise self._wrong(
                number, f"values in values in values, too deep to be read; the line begins {payload[:80]!r}"
            ) from error
        except (msgspec.DecodeError, ValueError) as error:
            raise self._wrong(number, f"{error}; the line begins {payload[:80]!r}") from error

    def _about_tail(self, tail: bytes, end: End | None) -> bytes:
        """Note what stands behind the last whole line; return it where it is the beginning of a line."""
        if not tail.strip():
            return b""
        if end is not None:
            raise self._wrong(
                self._n_line_ends + 1,
                f"behind the end line stands {tail[:40]!r}; was something appended? Take it away",
            )
        self._notes.append(cut_note(tail))
        return tail

    def _check_end(self, number: int, events: list[Event], end: End | None, *, allow_truncated: bool) -> None:
        if end is None and not allow_truncated:
            raise self._wrong(
                number,
                f"no end line; the session stopped after {len(events)} events. "
                "Use `--allow-truncated` to take what is there.",
            )
        if end is not None and end.events != len(events):
            raise self._wrong(
                number, f"the end line counts {end.events} events, the file holds {len(events)}"
            )


def cut_note(tail: bytes) -> str:
    """Say that a file ends within a line, of which `tail` is there."""
    return (
        f"the file ends within a line, {len(tail):,} bytes behind the last whole one: a power cut, "
        "or a copy that is not whole. Compare its size with the original's"
    )


def _broken(number: int, payload: bytes, digits: bytes) -> str:
    """Return what is wrong with a line whose chain ends in other digits than the ones that stand there."""
    if number == 1:
        for known in range(1, VERSION + 1):
            original = _VERSION_SAID.sub(b'"version":%d' % known, payload, count=1)
            if Chain().advance(original) == digits:
                return (
                    f"the header was changed after it was recorded: it was of version {known} of the format. "
                    f"{TAKE_THE_ORIGINAL}"
                )
        return (
            "the line's chain does not follow from it: the header was changed after it was recorded (a date, "
            f"a code, a version?). {TAKE_THE_ORIGINAL}"
        )
    return (
        "the line's chain does not follow from the lines before it: this line was changed, or one before "
        "it was changed, "
        f"removed or moved. {TAKE_THE_ORIGINAL}"
    )


def _these_lines(numbers: Sequence[int]) -> str:
    """Return "line 3 is", "lines 3 and 7 are" or "5 lines, from line 3 on, are"."""
    if len(numbers) == 1:
        return f"line {numbers[0]} is"
    if len(numbers) == 2:
        return f"lines {numbers[0]} and {numbers[1]} are"
    return f"{len(numbers)} lines, from line {numbers[0]} on, are"


def _plain(line: bytes) -> Any:
    """Return what a line of JSON says; None where it is none."""
    try:
        return msgspec.json.decode(line)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError):
        return None


def _looks_like(content: bytes) -> str:
    """Say in a sentence what a file of another kind seems to be, and what to do with it."""
    plain = _plain(content.partition(b"\n")[0].partition(b"\r")[0])
    if isinstance(plain, Mapping):
        kind = plain.get("format")
        if kind == "arl-reaction-times":
            return f"It is of the format {kind}, written by `arl calibrate`: `arl fit` reads it"
        if isinstance(kind, str):
            return f"It is of the format {kind}"
        return f"It is JSON of another program; it begins {content[:40]!r}"
    if b"\0" in content[:400]:
        return f"It holds binary data; it begins {content[:16]!r}"
    return (
        f"It begins {content[:40]!r}. A log of another program is imported by `arl import`, which lists the "
        f"kinds it knows"
    )
