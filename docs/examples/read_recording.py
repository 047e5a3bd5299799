"""Read a recording with nothing but Python's standard library: python read_recording.py FILE."""

import hashlib
import json
import sys
from typing import Any

MARK = b',"chain":"'


def read(path: str) -> tuple[dict[str, Any], list[dict[str, Any]], bool]:
    """Return the header, the events, and whether the session was closed properly.

    Raises:
        ValueError: a line was changed, lost or moved, or the file is of a version that this reader does not
        know.
    """
    with open(path, "rb") as file:
        whole, _, _ = file.read().rpartition(b"\n")  # behind the last newline: a line that was never finished
    running, records = hashlib.sha256(), []
    for number, line in enumerate(whole.split(b"\n"), start=1):
        payload, mark, chain = line.rpartition(MARK)
        running.update(payload + b"}")
        if not mark or chain != running.hexdigest()[:16].encode() + b'"}':
            raise ValueError(f"{path}:{number}: this line was changed, or one before it")
        records.append(json.loads(payload + b"}"))
    header = records.pop(0)
    if header.get("format") != "arl-recording" or header["version"] not in (1, 2):
        raise ValueError(f"{path}: not an arl-recording of version 1 or 2")
    closed = bool(records) and records[-1]["type"] == "end"
    if closed and records.pop()["events"] != len(records):
        raise ValueError(f"{path}: the end line counts other events")
    return header, records, closed


def presses(header: dict[str, Any], events: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return the presses that count, each with its time in seconds and the steps it was credited to."""
    taken_back = {event["press"] for event in events if event["type"] == "press-retracted"}
    credit = {event["press"]: event for event in events if event["type"] == "credit-given"}
    return [
        {
            "press": event["press"],
            "time_s": (event["time_ns"] - header["started_ns"]) / 1e9,
            "value": event["value"],
            "step": event["step"],
            "credit": dict(
                zip(credit[event["press"]]["steps"], credit[event["press"]]["shares"], strict=True)
            ),
        }
        for event in events
        if event["type"] == "key-pressed"
        and event["verdict"] == "accepted"
        and event["press"] not in taken_back
    ]


if __name__ == "__main__":
    found, all_events, _ = read(sys.argv[1])
    for press in presses(found, all_events):
        print(json.dumps(press))
