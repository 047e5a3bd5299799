"""Rules of trust against rates of wrong presses, as tables and as a figure: what both games' pages of
robustness have in common.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from studies.experiments import page
from studies.reaction_time.figures import COLORS, LINES
from studies.statistics import Interval

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOSTLY_WRONG = 80
"""Rate in per cent from which a participant is an adversary."""
WIDE_TICKS = (0.2, 0.5, 1, 2, 5, 10, 20, 50)
FINE_TICKS = (0.5, 0.6, 0.8, 1, 1.25, 1.5, 2)
"""Of ratios, where all of them lie within a factor of 3 or so of 1."""
LOWEST_DRAWN = 0.2
"""Smaller ratios are for the table: they would press all others together."""


@dataclass(frozen=True, slots=True)
class AtRate:
    """What came of a rule at one rate of wrong presses."""

    ratio: Interval
    """Of its scores to those of the environment alone."""
    weight: float
    """Mean w_h at the end of a trial."""


ByRule = Mapping[str, Mapping[int, AtRate]]
"""By the rule's label, then by the rate in per cent."""


def ratios_table(found: ByRule, rates: Sequence[int]) -> str:
    """Return ratios with their intervals, a row per rule."""
    return _table(found, rates, lambda cell: page.interval(cell.ratio))


def weights_table(found: ByRule, rates: Sequence[int]) -> str:
    """Return mean weights, a row per rule."""
    return _table(found, rates, lambda cell: f"{round(cell.weight, 2) + 0.0:.2f}")


def summary(found: ByRule) -> str:
    """Return which rules do no harm at any rate, and which gain from a participant who errs at 80 % or more,
    by their 95 % intervals.
    """
    harmless = [rule for rule, cells in found.items() if all(cell.ratio.high >= 1 for cell in cells.values())]
    adversary = [
        rule
        for rule, cells in found.items()
        if (wrong := [cell for rate, cell in cells.items() if rate >= MOSTLY_WRONG])
        and all(cell.ratio.low > 1 for cell in wrong)
    ]
    return f"""\
Significantly below the environment alone at no rate: {_listed(harmless)}. Significantly above it wherever {MOSTLY_WRONG} % or more are
wrong: {_listed(adversary)}.
"""  # noqa: E501


def in_short(found: ByRule, ours: str, alone: str) -> str:
    """Return a page's answer in three sentences.

    Args:
        found: every rule at every rate.
        ours: label of the rule that the page is about.
        alone: what scores are compared with, in words.
    """
    cells = found.get(ours, {})
    harm = [f"{rate} %" for rate, cell in cells.items() if cell.ratio.high < 1]
    at = "; ".join(f"{rate} % wrong: {page.interval(cell.ratio)}" for rate, cell in cells.items())
    best = max(
        ((rule, other[10]) for rule, other in found.items() if 10 in other),
        key=lambda pair: pair[1].ratio.estimate,
        default=None,
    )
    first = (
        f"Listening by the rule *{ours}* does significantly worse than {alone} at "
        f"{', '.join(harm) or 'no rate'} of wrong presses."
    )
    second = f"Its ratios are {at}." if at else "It was not played."
    third = (
        f"At 10 % wrong *{best[0]}* does best: {page.interval(best[1].ratio)}."
        if best
        else "Nothing else was played."
    )
    return f"**In short.** {first} {second} {third}\n"


def _listed(rules: Sequence[str]) -> str:
    return ", ".join(f"*{rule}*" for rule in rules) or "none"


def rates_figure(found: ByRule, rates: Sequence[int]) -> Figure:
    """Draw ratio and final weight against the rate, for the rules that were played at two rates or more."""
    figure = page.new_figure(7.2, 4.0)
    left, right = figure.subplots(1, 2)
    left.axhline(1.0, color="0.4", linewidth=1.0)
    shown = {rule: cells for rule, cells in found.items() if len(cells) >= 2}
    for place, (rule, cells) in enumerate(shown.items()):
        at = np.array(list(cells), dtype=np.float64)
        ratios = [cell.ratio for cell in cells.values()]
        middle = np.array([ratio.estimate for ratio in ratios])
        ends = np.array([[r.estimate - r.low for r in ratios], [r.high - r.estimate for r in ratios]])
        style = {
            "color": COLORS[place % len(COLORS)],
            "linestyle": LINES[place % len(LINES)],
            "marker": page.MARKERS[place % len(page.MARKERS)],
            "markersize": 4,
        }
        left.errorbar(at + (place - 2) * 0.8, middle, yerr=ends, capsize=2, label=rule, **style)
        right.plot(at, [cell.weight for cell in cells.values()], **style)
    left.set(xlabel="wrong presses (%)", ylabel="score / environment only", yscale="log", xticks=rates)
    right.set(xlabel="wrong presses (%)", ylabel="$w_h$ at the end", xticks=rates)
    low, high = left.get_ylim()
    low = max(low, LOWEST_DRAWN)
    left.set_ylim(low, high)
    ticks = [tick for tick in (FINE_TICKS if high / low < 6 else WIDE_TICKS) if low <= tick <= high]
    left.set_yticks(ticks)
    left.set_yticklabels([f"{tick:g}" for tick in ticks])
    left.set_yticks([], minor=True)
    for axes in (left, right):
        axes.grid(alpha=0.3)
    figure.legend(
        *left.get_legend_handles_labels(),
        loc="outside lower center",
        ncols=3,
        frameon=False,
        fontsize="small",
    )
    return figure


def _table(found: ByRule, rates: Sequence[int], tell: Callable[[AtRate], str]) -> str:
    rows = [
        [rule, *(tell(cells[rate]) if rate in cells else "" for rate in rates)]
        for rule, cells in found.items()
    ]
    return page.table(["rule", *(f"{rate} % wrong" for rate in rates)], rows)
