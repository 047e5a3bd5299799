"""The table and the figure of docs/decisions/cross-entropy-curves.md, from curves that were played before."""

from collections.abc import Sequence

from studies.fidelity.ce_curves import CurvePoint, compare

HEAD = ("noise", "iteration", "reference", "overflow-clearing", "fit-before-clear", "published")
SHOWN_RULES = ("reference", "overflow-clearing", "fit-before-clear")
"""`overflow` plays the same games as `fit-before-clear` where terminal boards are worth minus infinity."""


def curve_rows(ours: Sequence[CurvePoint], published: Sequence[CurvePoint]) -> list[tuple[str, ...]]:
    """Return the rows under HEAD: our medians, and lowest, median and highest of the published runs."""
    found = {(each.rules, each.noise, each.iteration): each for each in compare(ours, published)}
    rows = []
    for noise, iteration in dict.fromkeys((noise, iteration) for _, noise, iteration in found):
        of_rules = [found[rules, noise, iteration] for rules in SHOWN_RULES]
        one = of_rules[0]
        theirs = (one.published_min, one.published_median, one.published_max)
        rows.append(
            (
                noise,
                str(iteration),
                *(_number(each.median) for each in of_rules),
                " · ".join(map(_number, theirs)),
            )
        )
    return rows


def _number(lines: float) -> str:
    return f"{lines:,.0f}" if lines >= 99.95 else f"{lines:.1f}"
