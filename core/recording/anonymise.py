"""Copies of recordings that can be published: without dates, terminal facts, free text and codes.

Nothing that a replay or an analysis needs is changed: events keep their times, and every other byte. What is
removed stands in the header's texts; of events only the names of keys that mean nothing to the session are
removed.
"""

import hashlib
import hmac
import re
from base64 import b32encode
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, get_args

import msgspec

from core.events import KeyPressed, QuestionAnswered
from core.feedback.keys import KeyConfig
from core.numerics.clock import NS_PER_MS
from core.recording.chain import CHAIN_DIGITS, Chain
from core.recording.lines import CHAIN_MARK
from core.recording.reader import Recording
from core.recording.schema import End, Resumes, encode
from core.recording.undo import as_recorded

Removal = Literal["dates", "terminal", "free-text", "other-keys", "codes"]
"""What can be removed.

`dates`: wall-clock times. `terminal`: facts about the machine, except how times were measured. `free-text`:
texts that are neither settings nor versions (paths, names of files, remarks, typed answers). `other-keys`:
names of keys that mean nothing in the session: they may have been typed text. `codes`: participants get new
codes.
"""
REMOVALS: tuple[Removal, ...] = get_args(Removal)

NO_DATE = "(date removed)"
NO_TEXT = "(text removed)"
OTHER_KEY = "(other key)"
_DATE = re.compile(r"(?<!\d)\d{4}-?[01]\d-?[0-3]\d(?!\d)([T ]?[\d:.]+(Z|[+-]\d\d:?\d\d)?)?")
_MEASURING = re.compile(r"stamps|frames_per_s|timing_")
"""Begins the names of facts that say how exactly times were measured: an analysis needs them."""
_KEPT_SOURCES = re.compile(r"study\.|credit(?!_files$)|format$|condition( |$)|published$|anonymised|upgraded")
"""Begins the names of facts in `Header.source` that are settings, not texts."""
_OTHER_PRESS = b'"verdict":"other"'


@dataclass(frozen=True, slots=True)
class Anonymising:
    """What is removed, and how codes and hashes are made."""

    key: bytes = field(repr=False)
    """Secret, kept apart from the copies: new codes follow from it and from the old ones."""
    removed: frozenset[Removal] = frozenset(REMOVALS)
    keyed_hash: bool = False
    """Name the old file by HMAC-SHA256 under the key; False: by SHA-256, which any reader can compute of the
    old file."""

    def code(self, old: str) -> str:
        """Return the new code of a participant: `A` and 10 of the letters A-Z and digits 2-7.

        The same key gives the same code in every file. Without the key the old code cannot be worked out.
        """
        if "codes" not in self.removed:
            return old
        digest = hmac.digest(self.key, b"participant:" + old.encode(), "sha256")
        return "A" + b32encode(digest).decode()[:10]

    def about(self, content: bytes) -> dict[str, str]:
        """Return what a copy says about itself: what was done, and the hash of the old file."""
        words = {
            "dates": "dates",
            "terminal": "terminal facts",
            "free-text": "free text",
            "other-keys": "names of other keys",
        }
        gone = [text for name, text in words.items() if name in self.removed]
        said = f"removed: {', '.join(gone) or 'nothing'}"
        said += "; participant has a new code" if "codes" in self.removed else ""
        name, value = "anonymised_from_sha256", hashlib.sha256(content).hexdigest()
        if self.keyed_hash:
            name, value = "anonymised_from_hmac_sha256", hmac.digest(self.key, content, "sha256").hex()
        return {"anonymised": f"{said}; times and all else as recorded; sealed anew", name: value}

    def facts(self, facts: Mapping[str, str]) -> dict[str, str]:
        """Return facts about a machine as far as they are kept."""
        if "terminal" in self.removed:
            facts = {name: value for name, value in facts.items() if _MEASURING.match(name)}
        return {name: self.text(value) for name, value in facts.items()}

    def text(self, text: str) -> str:
        """Return a text without dates."""
        return _DATE.sub(NO_DATE, text) if "dates" in self.removed else text


def without_dates(value: Any) -> Any:
    """Return plain JSON with every date in a text replaced."""
    if isinstance(value, str):
        return _DATE.sub(NO_DATE, value)
    if isinstance(value, Mapping):
        return {name: without_dates(below) for name, below in value.items()}
    if isinstance(value, list):
        return [without_dates(below) for below in value]
    return value


def anonymised(recording: Recording, how: Anonymising, *, resumes: Resumes | None = None) -> bytes:
    """Return the content of a copy of a recording.

    The copy is of the same version of the format. A line that was being written when the session was cut off
    is not in it.

    Args:
        recording: as it was read.
        how: what is removed.
        resumes: what the copy says of the recording that it goes on with; as it was by default.

    Raises:
        OSError: the recording's file cannot be read again.
    """
    about = how.about(recording.path.read_bytes())
    retract = _retract_keys(recording)
    answering = _answering_keys(recording)
    others = _OtherKeys(_repeat_interval_ns(recording))

    def change_event(payload: bytes) -> bytes:
        if "other-keys" not in how.removed or _OTHER_PRESS not in payload:
            return payload
        plain = msgspec.json.decode(payload)
        if (plain.get("read_as") or plain["key"]) in retract:
            return payload  # it takes presses back: without it, they would be taken back by nothing
        if plain["key"] in answering:
            return payload  # from it follows which option was chosen
        plain["key"] = others.name(plain.get("person", 0), plain["key"], plain["time_ns"])
        for name in ("read_as", "layout"):
            plain.pop(name, None)
        return msgspec.json.encode(plain)

    return resealed(recording, lambda header: _header(header, how), change_event, about, resumes=resumes)


def _answering_keys(recording: Recording) -> set[str]:
    """Return the keys that answered the agent's questions."""
    answering = {event.press for event in recording.events if isinstance(event, QuestionAnswered)}
    return {
        event.key for event in recording.events if isinstance(event, KeyPressed) and event.press in answering
    }


class _OtherKeys:
    """Gives names to keys that mean nothing, so that no text can be read from the names.

    Whether a key was held is told by how soon it came again (`core.feedback.keys.PressGate`): sooner than an
    interval, later, or for the first time. This much the names keep. So a key has its last name again within
    the interval, a new one when it is pressed for the first time, and any free one otherwise.
    """

    def __init__(self, interval_ns: int) -> None:
        self._interval_ns = interval_ns
        self._last: dict[tuple[int, str], tuple[str, int]] = {}
        self._used: dict[int, dict[str, int]] = {}

    def name(self, person: int, key: str, time_ns: int) -> str:
        """Return the name of a press's key."""
        used = self._used.setdefault(person, {})
        name, last_ns = self._last.get((person, key), ("", 0))
        if not name:
            name = f"{OTHER_KEY[:-1]} {len(used) + 1})" if used else OTHER_KEY
        elif time_ns - last_ns >= self._interval_ns:
            free = (known for known, used_ns in used.items() if time_ns - used_ns >= self._interval_ns)
            name = next(free, name)
        self._last[person, key] = name, time_ns
        used[name] = time_ns
        return name


def _repeat_interval_ns(recording: Recording) -> int:
    """Return within which time two presses of one key may be a held key's, ns."""
    keys = recording.header.protocol.get("keys", {})
    interval_ms = keys.get("repeat_interval_ms") if isinstance(keys, Mapping) else None
    return NS_PER_MS * (KeyConfig().repeat_interval_ms if interval_ms is None else int(interval_ms))


def _retract_keys(recording: Recording) -> set[str]:
    """Return the keys that take presses back; where the protocol does not say, that of all by default."""
    protocol = recording.header.protocol
    keys = protocol.get("people") or [protocol.get("keys", {})]
    return {
        str(each.get("retract", KeyConfig().retract)) if isinstance(each, Mapping) else KeyConfig().retract
        for each in keys
    }


def resealed(
    recording: Recording,
    change_header: Callable[[dict[str, Any]], dict[str, Any]],
    change_event: Callable[[bytes], bytes],
    about: Mapping[str, str],
    *,
    resumes: Resumes | None = None,
) -> bytes:
    """Return a recording's content with its header and its events changed, and a new chain.

    Args:
        recording: as it was read.
        change_header: takes and returns the header in plain JSON types.
        change_event: takes and returns the JSON of one line.
        about: added to the header's `source`.
        resumes: what the header says of the recording that this one goes on with; as it was by default.
    """
    content = as_recorded(recording.path, recording.path.read_bytes()).content
    lines = [line for line in content.split(b"\n") if line.strip()]
    n_lines = 1 + len(recording.events) + recording.complete
    header, *events = [line.rpartition(CHAIN_MARK)[0] + b"}" for line in lines[:n_lines]]
    plain = change_header(msgspec.json.decode(header))
    plain["source"] = plain.get("source", {}) | dict(about)
    if resumes is not None:
        plain["resumes"] = msgspec.to_builtins(resumes)
    if recording.signature:
        # It was about the lines as they were.
        events[-1] = encode(End(events=len(recording.events)))
    chain = Chain()
    sealed = [chain.seal(msgspec.json.encode(plain))]
    sealed += [chain.seal(change_event(event)) for event in events]
    return b"".join(sealed)


def last_chain(content: bytes) -> str:
    """Return the chain of the last line of a recording's content: 16 hex digits."""
    return content.rstrip(b"\n").rpartition(CHAIN_MARK)[2][:CHAIN_DIGITS].decode()


def _header(plain: dict[str, Any], how: Anonymising) -> dict[str, Any]:
    old = plain["participant"]
    people = plain.get("participants", [])
    source = _source(plain.get("source", {}), how, [old, *people])
    if people:
        plain = plain | {
            "participants": [how.code(name) for name in people],
            "protocol": plain["protocol"]
            | {
                "people": [
                    each | {"name": how.code(each["name"])} for each in plain["protocol"].get("people", [])
                ]
            },
        }
    if "dates" in how.removed:
        plain = without_dates(plain)
    return plain | {
        "participant": how.code(old),
        "terminal": how.facts(plain.get("terminal", {})),
        "source": source,
    }


def _source(source: Mapping[str, str], how: Anonymising, codes: Sequence[str]) -> dict[str, str]:
    kept: dict[str, str] = {}
    for name, value in source.items():
        if "free-text" in how.removed and not _KEPT_SOURCES.match(name):
            value = NO_TEXT
        for old in codes if "codes" in how.removed else ():
            name, value = (
                re.sub(rf"(?<![\w]){re.escape(old)}(?![\w])", how.code(old), text) for text in (name, value)
            )
        kept[name] = how.text(value)
    return kept


def removals(kept: Collection[str]) -> frozenset[Removal]:
    """Return what is removed where these are kept."""
    return frozenset(name for name in REMOVALS if name not in kept)
