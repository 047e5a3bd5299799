"""A number in a cell, as programs and spreadsheets of any locale write it; nothing is guessed."""

import json
import math
import re
from typing import Literal

from studies.reaction_time.tables.contract import MISSING, Columns, ReadError, shown

_SPACES = "\u00a0\u202f\u2009 "
_GROUP = f"['\u2019{_SPACES}]"
_WITH_COMMA = re.compile(
    rf"-?\d{{1,3}}(?:(?:{_GROUP}|\.)\d{{3}})+,\d+|-?\d{{1,3}}(?:{_GROUP}\d{{3}})+|-?\d*,?\d+"
)
"""What a decimal comma allows: 1.220,5 and 1 220,5 and 0,431, but not 1.023, which may be either."""
_WITH_POINT = re.compile(rf"-?\d{{1,3}}(?:(?:{_GROUP}|,)\d{{3}})+\.\d+|-?\d{{1,3}}(?:{_GROUP}\d{{3}})+")
_LOOKS_LIKE_A_COMMA = re.compile(rf"-?[\d.'\u2019{_SPACES}]*,\d+")


def is_missing(text: str) -> bool:
    """Return whether a cell says that it holds no value."""
    return text.strip().lower() in MISSING


def number_of(text: str, where: str, columns: Columns) -> float | None:
    """Return the number in a cell; None where the cell says that there is none, or where it is not finite.

    Args:
        text: the cell.
        where: file, line and column for the message.
        columns: the decimal sign, and what to do about lists.

    Raises:
        ReadError: the cell holds something else.
    """
    text = text.strip()
    if is_missing(text):
        return None
    times = list_of(text)
    if times is not None:
        return _one_of(times, text, where, columns)
    try:
        value = float(_plain(text, columns.decimal))
    except ValueError:
        raise ReadError(f"{where} holds {shown(text)}, not a number; {_advice(text, columns)}") from None
    return value if math.isfinite(value) else None


def list_of(text: str) -> list[float | None] | None:
    """Return the numbers of a cell such as `[0.41, 0.83]`; None where the cell holds no list."""
    if not (text.startswith("[") and text.endswith("]")):
        return None
    try:
        found = json.loads(re.sub(r"\b(None|nan|NaN)\b", "null", text))
    except (ValueError, RecursionError):
        return None
    numbers = [None if isinstance(x, bool) or not isinstance(x, int | float | None) else x for x in found]
    return [None if x is None else float(x) for x in numbers]


def _one_of(times: list[float | None], text: str, where: str, columns: Columns) -> float | None:
    if columns.of_list is None and len(times) > 1:
        raise ReadError(
            f"{where} holds a list of {len(times)} times, {shown(text)}: every key press of the trial was"
            " stored. Which one is the reaction? `arl fit --list first` takes the first of each list, --list"
            " last the last; in PsychoPy 'Store: first key' writes one time"
        )
    numbers = [time for time in times if time is not None]
    return (numbers[-1] if columns.of_list == "last" else numbers[0]) if numbers else None


def _plain(text: str, decimal: Literal[".", ","]) -> str:
    """Return a number as Python reads it; raise ValueError where it may be read in two ways."""
    if decimal == ",":
        if not _WITH_COMMA.fullmatch(text):
            # With a decimal comma a point alone can only separate thousands, which we do not take.
            return text.replace(".", "?").replace(",", ".")
        return re.sub(rf"{_GROUP}|\.", "", text).replace(",", ".")
    if _WITH_POINT.fullmatch(text):
        return re.sub(rf"{_GROUP}|,", "", text)
    if "_" in text:
        raise ValueError("Python's own 1_000")
    return text


def _advice(text: str, columns: Columns) -> str:
    if columns.decimal == "." and _LOOKS_LIKE_A_COMMA.fullmatch(text):
        return "if that is a decimal comma, say decimal=',' (`arl fit --decimal ,`)"
    if columns.decimal == "," and re.fullmatch(r"-?\d+\.\d+", text):
        return "beside decimal commas a point may separate decimals or thousands: write the column in one way"
    unit = re.fullmatch(r"-?[\d.,]+\s*(s|sec|ms|msec|us)", text, re.IGNORECASE)
    if unit:
        return "take the unit out of the cells and state it (--unit)"
    return "leave missing values empty or n/a"
