"""Change bytes as damage and ill will do: flipped, cut, doubled, exchanged, and with values that nobody
expects."""

import json
import random

from core.recording.chain import Chain

TOKENS = (
    b"", b"0", b"-1", b"1", b"NaN", b"Infinity", b"1e999", b"-1e308", b"9223372036854775808", b"1" * 400, b"null",  # noqa: E501
    b"true", b'""', b"[]", b"{}", b"[" * 2000, b'{"a":' * 2000, b"\x1b]0;t\x07", b"\x1b[2J", b"\xff\xfe", b"\xc2\x9b31m",  # noqa: E501
    b"\xe2\x80\xae", b"\x00", b"\r\n", b"\n", b"../../etc/passwd", b"a" * 5000, b'"', b"'''", b",", b";", b"\t", b":", b"=",  # noqa: E501
)  # fmt: skip
NUMBERS = (
    0,
    -1,
    1,
    2**31,
    2**63 - 1,
    2**63,
    -(2**63),
    10**300,
    1e308,
    -1e308,
    1e-308,
    0.5,
    True,
    None,
    "",
    "x",
    [],
    {},
)


def mutated(seed: bytes, others: list[bytes], rng: random.Random) -> bytes:
    """Return a seed with one to five changes.

    Args:
        seed: what is changed.
        others: what pieces are taken from.
        rng: decides.
    """
    content = bytearray(seed)
    for _ in range(rng.choice((1, 1, 1, 2, 3, 5))):
        _change(content, others, rng)
    return bytes(content)


def _change(content: bytearray, others: list[bytes], rng: random.Random) -> None:
    at = rng.randrange(len(content) + 1)
    to = min(len(content), at + rng.choice((1, 2, 4, 16, 64, 1000)))
    match rng.randrange(8):
        case 0 if at < len(content):
            content[at] ^= 1 << rng.randrange(8)
        case 1 if at < len(content):
            content[at] = rng.randrange(256)
        case 2:
            del content[at:to]
        case 3:
            content[at:at] = content[at:to]
        case 4:
            content[at:to] = rng.choice(TOKENS)
        case 5:
            content[at:at] = rng.choice(TOKENS)
        case 6:
            other = rng.choice(others)
            begin = rng.randrange(len(other) + 1)
            content[at:to] = other[begin : begin + rng.choice((1, 8, 64, 512))]
        case _:
            del content[rng.choice((at, len(content) // 2)) :]


def resealed(content: bytes) -> bytes:
    """Return the lines of a recording with a chain that is right again."""
    chain, lines = Chain(), []
    for line in content.split(b"\n"):
        payload = line.rpartition(b',"chain":"')[0] + b"}" if b',"chain":"' in line else line
        if payload.strip():
            lines.append(chain.seal(payload))
    return b"".join(lines)


def changed_values(content: bytes, rng: random.Random) -> bytes:
    """Return a recording of which events are moved, doubled or left out, or hold other values; sealed
    anew."""
    lines = [json.loads(line) for line in content.splitlines()]
    for _ in range(rng.choice((1, 1, 2, 4))):
        at = rng.randrange(len(lines))
        match rng.randrange(6):
            case 0 if len(lines) > 2 and at:
                del lines[at]
            case 1 if at:
                lines.insert(rng.randrange(1, len(lines)), dict(lines[at]))
            case 2 if at:
                lines.insert(rng.randrange(1, len(lines)), lines.pop(at))
            case _:
                _change_value(lines[at], rng)
    if lines[-1].get("type") == "end" and rng.random() < 0.9:
        lines[-1]["events"] = len(lines) - 2
    chain = Chain()
    for line in lines:
        line.pop("chain", None)
    return b"".join(chain.seal(json.dumps(line, separators=(",", ":")).encode()) for line in lines)


def _change_value(line: dict, rng: random.Random) -> None:
    table = line
    while names := [name for name in table if name not in ("type", "chain")]:
        name = rng.choice(names)
        value = table[name]
        if not isinstance(value, dict) or rng.random() < 0.1:
            break
        table = value
    else:
        return  # a table without keys
    if isinstance(value, int | float) and not isinstance(value, bool) and rng.random() < 0.7:
        table[name] = value + rng.choice((1, -1, 20_000_000, -20_000_000, 2**40, -(2**40)))
    elif isinstance(value, list) and value and rng.random() < 0.5:
        value[rng.randrange(len(value))] = rng.choice(NUMBERS)
    else:
        table[name] = rng.choice(NUMBERS)
