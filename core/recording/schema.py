"""The lines of a recording: one header, events in the order in which they happened, one end line.

A recording is a text file of JSON objects, one per line. Every line ends with the field `chain`, the first 16
hex digits of the running SHA-256 over all lines so far (without their chains): an edited, lost or exchanged
line is noticed, and where. The format is described for readers of other languages in `recordings/README.md`.
"""

import dataclasses
from collections.abc import Mapping
from typing import Any, Literal

import msgspec

from core.events import Event, Record

FORMAT: Literal["arl-recording"] = "arl-recording"
VERSION = 2
"""Version that is written. 1 is read, too (`core.recording.version_1`)."""
FIRST_GAME = "tetris"
"""The game of protocols that name none: recordings made before there was a second game do not."""


class Resumes(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Which recording a resumed session goes on with, and how much of it belongs to the session."""

    file: str
    """Name of the older recording, in the same folder."""
    chain: str
    """Its last chain: 16 hex digits that no other content has."""
    inputs: int
    """The session's first inputs, so many, are those of the older recording; its later ones belong to a game
    that was broken off."""
    outputs: int
    """The same of its outputs."""
    shift_ns: int
    """Added to every time of the older recording, <= 0: so it ends before this one begins, also where the
    computer was switched off in between and its clock began again."""


class Header(Record, frozen=True, kw_only=True, omit_defaults=False, tag="header"):
    """First line: what was run, by which program, with whom, on which terminal."""

    format: Literal["arl-recording"] = FORMAT
    version: int = VERSION
    origin: Literal["live", "simulated", "imported"]
    created_utc: str
    """Wall time at the start, ISO 8601: the only wall time in the file."""
    clock: str
    """Name of the clock behind all `_ns` fields."""
    clock_resolution_ns: int
    started_ns: int
    """That clock's time at `created_utc`."""
    participant: str
    """Pseudonym; never a name."""
    root_seed: int
    protocol: dict[str, Any]
    """The whole configuration, see `core.session.protocol.Protocol`."""
    software: dict[str, str]
    """Versions of this program, its commit, Python and the libraries that numbers depend on."""
    terminal: dict[str, str] = msgspec.field(default_factory=dict)
    """Facts about the terminal: TERM, size, multiplexer, connection, and how exactly times are measured in
    it."""
    departures: list[str] = msgspec.field(default_factory=list)
    """Where this configuration departs from the paper, in words."""
    source: dict[str, str] = msgspec.field(default_factory=dict)
    """Where an imported recording comes from; where the credit rule of a live one comes from."""
    study: dict[str, str] = msgspec.field(default_factory=dict)
    """Where the session belongs in a study: its name, version and hash, place, order, sitting, step,
    condition. Empty outside of studies."""
    participants: list[str] | msgspec.UnsetType = msgspec.UNSET
    """Codes of several people at one keyboard, in the order of `KeyPressed.person`; not there where one
    participates, whose code is `participant`."""
    resumes: Resumes | None = None
    """What a resumed session goes on with (`core.recording.joined`); None: it begins with this file."""

    def __post_init__(self) -> None:
        if not 1 <= self.version <= VERSION:
            raise ValueError(
                f"version {self.version} of the format; this program reads versions 1 to {VERSION}"
            )
        if self.root_seed < 0:
            raise ValueError(f"root_seed is >= 0, got {self.root_seed}")


def code_of(header: Header, person: int) -> str:
    """Return the code of the person who made a press: of several people at one keyboard their own.

    Args:
        header: of the recording.
        person: as in `KeyPressed.person`; of -1, nobody's key, the code is that of the group.
    """
    names = header.participants
    if isinstance(names, list) and 0 <= person < len(names):
        return names[person]
    return header.participant


class End(Record, frozen=True, kw_only=True, tag="end"):
    """Last line of a session that was closed properly."""

    events: int
    """Number of lines between the header and this one."""
    signature: str = ""
    """Ed25519 signature of all lines before, hex (`core.recording.signature`); "" where there is none."""


Line = Header | Event | End

DURABLE = frozenset(
    {
        "KeyPressed",
        "PressRetracted",
        "QuestionAnswered",
        "TimeGap",
        "EpisodeEnded",
        "UnseenPlayed",
        "StopAsked",
        "SessionEnded",
        "End",
    }
)
"""Records that are forced to the disk at once; the others are on their way to it."""


def encode(line: Line) -> bytes:
    """Return a line as JSON, without chain and newline."""
    return msgspec.json.encode(line)


def to_plain(value: object) -> dict[str, Any]:
    """Return a configuration as plain JSON types, for `Header.protocol`.

    A setting that a table names in `LATER` is left out at its default, so that a session without it is
    recorded as before there was such a setting. So is one that it names in `OLD`: its place in files of
    earlier versions, which are still read.
    """
    plain = msgspec.to_builtins(value)
    assert isinstance(plain, dict)
    leave_out_later(value, plain)
    return plain


def leave_out_later(value: object, plain: object) -> None:
    """Take out of a configuration's plain types what its tables name in `LATER` or `OLD`, if at the default.

    Args:
        value: structs, dataclasses, lists and tables of them.
        plain: the same as `msgspec.to_builtins` gives it; changed in place.
    """
    if isinstance(value, Mapping) and isinstance(plain, dict):
        for key, held in value.items():
            leave_out_later(held, plain.get(key))
    elif isinstance(value, list | tuple) and isinstance(plain, list | tuple):
        for held, its in zip(value, plain, strict=False):
            leave_out_later(held, its)
    elif dataclasses.is_dataclass(value) and isinstance(plain, dict):
        for each in dataclasses.fields(value):
            leave_out_later(getattr(value, each.name), plain.get(each.name))
    elif isinstance(value, msgspec.Struct) and isinstance(plain, dict):
        later: frozenset[str] = getattr(value, "LATER", frozenset()) | getattr(value, "OLD", frozenset())
        for field in msgspec.structs.fields(value):
            held = getattr(value, field.name)
            if field.name in later and held == field.default:
                plain.pop(field.encode_name, None)
            else:
                leave_out_later(held, plain.get(field.encode_name))
