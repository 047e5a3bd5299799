"""The table of `arl replay` as a figure."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from studies.what_if import WhatIfRow


def draw(rows: "Sequence[WhatIfRow]", path: Path, units: str = "lines") -> None:
    """Draw lines (or other `units`) per game with intervals, a row per credit rule and a mark per scheme; the suffix says the format.

    Raises:
        ValueError: matplotlib does not know the suffix.
    """
    # Half a second that only this needs; Figure, not pyplot: no window system is asked for.
    from matplotlib.figure import Figure

    credits = list(dict.fromkeys(row.credit for row in rows))
    schemes = list(dict.fromkeys(row.scheme for row in rows))
    figure = Figure(figsize=(7.0, 1.4 + 0.5 * len(credits)), layout="constrained")
    axes = figure.add_subplot()
    for number, scheme in enumerate(schemes):
        shown = [row for row in rows if row.scheme == scheme]
        shift = 0.0 if len(schemes) == 1 else 0.5 * (number / (len(schemes) - 1) - 0.5)
        centre = [row.lines.estimate for row in shown]
        axes.errorbar(
            centre,
            [credits.index(row.credit) + shift for row in shown],
            xerr=[
                [row.lines.estimate - row.lines.low for row in shown],
                [row.lines.high - row.lines.estimate for row in shown],
            ],
            fmt="o^sDvP*X"[number % 8],
            capsize=3,
            label=scheme,
        )
    axes.set_yticks(range(len(credits)), credits)
    axes.set_ylim(len(credits) - 0.5, -0.5)
    # Policies differ by factors of a hundred, and some clear nothing at all.
    axes.set_xscale("symlog", linthresh=1.0)
    axes.set_xlim(left=0.0)
    axes.set_xlabel(f"{units} per game on fresh seeds, with {rows[0].lines.level:.0%} intervals")
    axes.set_ylabel("credit rule")
    if len(schemes) > 1:
        axes.legend(title="scheme")
    axes.grid(axis="x", alpha=0.3)
    figure.savefig(path, dpi=150)
