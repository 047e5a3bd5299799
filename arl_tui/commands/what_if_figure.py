"""The table of `arl replay` as a figure."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from studies.statistics import Interval
    from studies.what_if import WhatIfRow


def draw(rows: "Sequence[WhatIfRow]", path: Path, units: str = "lines") -> None:
    """Draw lines (or other `units`) per game, and their differences to the first row, with intervals.

    There is a row per credit rule and a mark per scheme. The suffix of the file says its format.

    Raises:
        ValueError: matplotlib does not know the suffix.
    """
    # Half a second that only this needs; Figure, not pyplot: no window system is asked for.
    from matplotlib.figure import Figure

    credits = list(dict.fromkeys(row.credit for row in rows))
    schemes = list(dict.fromkeys(row.rule for row in rows))
    figure = Figure(figsize=(10.0, 1.6 + 0.5 * len(credits) + 0.1 * len(schemes)), layout="constrained")
    scores, differences = figure.subplots(1, 2, sharey=True)
    for number, scheme in enumerate(schemes):
        shown = [row for row in rows if row.rule == scheme]
        shift = 0.0 if len(schemes) == 1 else 0.5 * (number / (len(schemes) - 1) - 0.5)
        mark, colour = "o^sDvP*X"[number % 8], f"C{number % 10}"
        places = [credits.index(row.credit) + shift for row in shown]
        _bars(scores, [row.lines for row in shown], places, mark, colour, _in_use(scheme, shown))
        compared = [(row.difference, place) for row, place in zip(shown, places, strict=True)]
        known = [(difference, place) for difference, place in compared if difference is not None]
        _bars(differences, [d for d, _ in known], [place for _, place in known], mark, colour, None)
    scores.set_yticks(range(len(credits)), credits)
    scores.set_ylim(len(credits) - 0.5, -0.5)
    # Policies differ by factors of a hundred, and some clear nothing at all.
    scores.set_xscale("symlog", linthresh=1.0)
    scores.set_xlim(left=0.0)
    scores.set_xlabel(f"{units} per game on fresh seeds, with {rows[0].lines.level:.0%} intervals")
    scores.set_ylabel("credit rule")
    differences.axvline(0.0, color="grey", linewidth=0.8)
    differences.set_xlabel(f"minus {rows[0].credit}, {rows[0].rule} (paired by seed)")
    if len(schemes) > 1:
        figure.legend(loc="outside upper center", ncols=2, fontsize="small")
    for axes in (scores, differences):
        axes.grid(axis="x", alpha=0.3)
    figure.savefig(path, dpi=150)


def _bars(
    axes: "Axes",
    intervals: "Sequence[Interval]",
    places: Sequence[float],
    mark: str,
    colour: str,
    label: str | None,
) -> None:
    centre = [interval.estimate for interval in intervals]
    below = [interval.estimate - interval.low for interval in intervals]
    above = [interval.high - interval.estimate for interval in intervals]
    axes.errorbar(centre, places, xerr=[below, above], fmt=mark, color=colour, capsize=3, label=label)


def _in_use(scheme: str, rows: "Sequence[WhatIfRow]") -> str:
    """Return the scheme with the weight that it used, or the range of them."""
    low, high = min(row.weight for row in rows), max(row.weight for row in rows)
    return f"{scheme}, weight {low:.2g}" + ("" if low == high else f" to {high:.2g}")
