"""What is asked of `arl fit`, and how it refuses: what its other modules share."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import click

from arl_tui.command_line import say
from core.system.foreign_text import printable_lines

if TYPE_CHECKING:
    from studies.reaction_time.tables.contract import Unit

__all__ = ["FAULTS", "InputError", "Request", "say"]

FAULTS = ("negative", "absurd")
"""Verdicts that no participant can cause."""


class InputError(click.ClickException):
    """The files cannot be used: status 2, as for any wrong use of the command."""

    exit_code = 2

    def format_message(self) -> str:
        """Return the message without anything from a file that a terminal would obey."""
        return printable_lines(self.message)


@dataclass(frozen=True, kw_only=True)
class Request:
    """Everything asked of the command. See its options."""

    preset: str | None
    column: tuple[str, ...]
    unit: "Unit | None"
    keep: tuple[str, ...]
    by: tuple[str, ...]
    decimal: Literal[".", ","]
    waited: float | None
    of_list: Literal["first", "last"] | None
    missing: tuple[str, ...]
    encoding: str | None
    trust_magnitudes: bool
    allow_faults: bool
    task: str | None
    only: tuple[str, ...]
    as_one: bool
    anticipation_below: float
    slow_above: float | None
    absurd_above: float
    keep_practice: bool
    keep_wrong: bool
    time_outs: Literal["censor", "exclude"]
    pooled: bool
    level: float
    resamples: int
    goodness: int | None
    seed: int
    workers: int | None
    figure: Path | None
    json_path: str | None
    html: Path | None
    out: Path | None
