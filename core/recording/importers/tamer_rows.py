"""Reading TAMER's Tetris logs: the rows of each episode as they stand; `tamer_log` puts them right."""

import json
import re
from dataclasses import dataclass
from pathlib import Path

from core.numerics.clock import NS_PER_S
from core.recording.importers.contract import ImporterError

ROWS, COLUMNS = 20, 10
N_CELLS = ROWS * COLUMNS
N_STATE = 7
"""Integers behind the cells: block mobile, piece, rotation, x, y, columns, rows."""

LARGEST = 1e6
"""No reward or value of these logs is as large: TAMER's are at most 10."""
MOST_DIGITS = 9
"""Of whole seconds: 31 years."""

_ONE_PRESS = r"\{-?\d+(?:\.\d+)? @ \d+(?:\.\d+)?\}"
_PRESSES = re.compile(rf"\[({_ONE_PRESS}(, {_ONE_PRESS})*)?\]")
_PRESS = re.compile(r"\{(\S+) @ (\S+?)\}")


class TamerLogError(ImporterError):
    """A line of a TAMER log cannot be understood; the message names file and line."""


@dataclass(frozen=True, slots=True)
class Row:
    """One line of the log, read but not yet put right."""

    line: int
    """Line number in the file, from 1."""
    board: tuple[int, ...]
    """Column bitboards, bit r = row r from the bottom; empty on a terminal row."""
    piece: int
    """Id of the falling piece (TAMER's ids are ours); -1 on a terminal row."""
    reward: float
    presses: tuple[tuple[int, float], ...]
    """(time in ns, value) as listed on this row."""
    training: bool
    start_ns: int

    @property
    def terminal(self) -> bool:
        """Whether the row only closes its episode."""
        return self.piece < 0


def read_tamer_log(path: Path) -> tuple[str, list[list[Row]]]:
    """Return the parameter string and the rows of each episode, unmended.

    Raises:
        TamerLogError: a line cannot be understood, or there is no step at all.
    """
    lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    if not lines or not lines[0].startswith("("):
        raise TamerLogError(f"{path}:1: expected TAMER's parameters in parentheses, got {_start(lines)!r}")
    episodes: list[list[Row]] = [[]]
    for number, line in enumerate(lines[1:], start=2):
        if line.strip() == "finished":
            break
        if line.strip():
            episodes[-1].append(_read_row(path, number, line))
        elif episodes[-1]:
            episodes.append([])
    if not episodes[-1]:
        episodes.pop()
    if not episodes:
        raise TamerLogError(f"{path}: the log holds no step")
    return lines[0], episodes


def _start(lines: list[str]) -> str:
    return lines[0][:40] if lines else ""


def _read_row(path: Path, number: int, line: str) -> Row:
    try:
        return _parse_row(number, line)
    except ValueError as error:
        raise TamerLogError(f"{path}:{number}: {error}; the line begins {line[:60]!r}") from None


def _parse_row(number: int, line: str) -> Row:
    fields = line.split(":")
    if len(fields) != 8:
        raise ValueError(f"expected 8 fields separated by colons, got {len(fields)}")
    state, _, _, _, reward, presses, training, start = fields
    if not _PRESSES.fullmatch(presses):
        raise ValueError(f"expected presses as [{{value @ seconds}}, ...], got {presses[:60]!r}")
    if training not in ("true", "false"):
        raise ValueError(f"expected true or false for training, got {training!r}")
    board, piece = _parse_state(state)
    return Row(
        line=number,
        board=board,
        piece=piece,
        reward=_finite(reward, "a reward"),
        presses=tuple(
            (_nanoseconds(time), _finite(value, "the value of a press"))
            for value, time in _PRESS.findall(presses)
        ),
        training=training == "true",
        start_ns=_nanoseconds(start),
    )


def _parse_state(text: str) -> tuple[tuple[int, ...], int]:
    """Return column bitboards and the piece; an empty board and -1 for a terminal row."""
    try:
        numbers = json.loads(text)
    except (ValueError, RecursionError):  # nested too deeply, or a number of thousands of digits
        raise ValueError("the first field is not a list of integers") from None
    if numbers == []:
        return (), -1
    if not isinstance(numbers, list) or not all(isinstance(number, int) for number in numbers):
        raise ValueError("the first field is not a list of integers")
    if len(numbers) != N_CELLS + N_STATE:
        raise ValueError(
            f"expected {N_CELLS} cells and {N_STATE} numbers of state, got {len(numbers)} in all: "
            "is this the log of another domain than Tetris?"
        )
    piece = numbers[N_CELLS + 1]
    if not 0 <= piece < 7:
        raise ValueError(f"expected a piece id from 0 to 6, got {piece}")
    # Cells are row-major from the top; our bit r is row r from the bottom.
    board = tuple(
        sum(1 << (ROWS - 1 - row) for row in range(ROWS) if numbers[row * COLUMNS + column])
        for column in range(COLUMNS)
    )
    return board, piece


def _finite(text: str, what: str) -> float:
    number = float(text)
    if not abs(number) <= LARGEST:
        raise ValueError(f"expected {what} of at most {LARGEST:g}, got {text[:40]}")
    return number


def _nanoseconds(text: str) -> int:
    """Return a decimal number of seconds in nanoseconds, exactly."""
    if not re.fullmatch(r"\d+(\.\d+)?", text):
        raise ValueError(f"expected a time in seconds, got {text!r}")
    whole, _, fraction = text.partition(".")
    if len(whole.lstrip("0")) > MOST_DIGITS:
        raise ValueError(
            f"expected a time of at most {MOST_DIGITS} digits of seconds, got {len(whole)} digits"
        )
    return int(whole) * NS_PER_S + int(fraction[:9].ljust(9, "0"))
