"""Makes the page *What people's delays look like*: reactions and evaluations of real people side by side.

`python -m studies.evaluations.delays_page docs` reads the folder of real data that ARL_DATA names (or `--data
FOLDER`) and writes `results/delays.md` and its figure below the folder of documentation. Every number is from
that run, which takes half a minute. The page holds figures only: no data are copied.
"""

import argparse
import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from core.numerics.streams import stream
from studies.evaluations.delays import (
    FEWEST,
    MOMENTS,
    ONSET,
    STEPS_S,
    CreditOnTarget,
    Delays,
    OfValue,
    by_value,
    credit_on_target,
    evaluations,
    fit_of,
    fractions_of_variance,
    reactions,
)
from studies.reaction_time.families import GAMMA, SHIFTED_GAMMA
from studies.statistics import Interval, paired_difference

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ROOT_SEED = 1
MIDDLE_STEP_S = 1.0
OWN, OTHERS = "a gamma of one's own", "one gamma of all others"
PAPER, BY_VALUE = "paper: gamma(2.5, 0.3)", "one's own, by the value's size"


def page(sets: Sequence[Delays], judged: Delays) -> str:
    """Return the page in Markdown.

    Args:
        sets: all tasks, evaluations among them, in the order of the columns.
        judged: the evaluations.
    """
    credit = {one.name: credit_on_target(one, MOMENTS) for one in sets}
    onset = {one.name: credit_on_target(one, ONSET) for one in sets}
    values = by_value(judged)
    parts = [
        "# What people's delays look like",
        _answer(judged, sets),
        "Data: " + "; ".join(_source(one) for one in sets) + ".",
        (
            "Made by `python -m studies.evaluations.delays_page docs` from the folder that `ARL_DATA` names."
            " Limits: nothing below 0.1 s; nothing above "
            + ", ".join(f"{one.slow_above_s:g} s ({one.name})" for one in sets)
            + "."
        ),
        "## More in short",
        _in_short(sets, judged, values, credit[judged.name]),
        "![Delays pooled, medians of people, and evaluations by value](../figures/delays.png)",
        "## All delays together",
        _together_table(sets),
        "## From person to person",
        _people_table(sets),
        "The best family by AIC: " + "; ".join(_best_words(one) for one in sets) + ".",
        "## How the delay depends on the value given",
        _value_table(values),
        _value_words(judged, values),
        "## What it means for credit",
        _credit_words(),
        *(part for one in sets for part in (f"### {one.name.capitalize()}", _credit_table(credit[one.name]))),
        _own_words(sets, credit, judged),
        "## Where the step's appearance is what is judged",
        _onset_words(onset[judged.name]),
        "See also `reaction_time.md` and `../trusting-a-fit.md`.",
    ]
    return "\n\n".join(parts) + "\n"


def _source(one: Delays) -> str:
    n = f"{len(one.times_s)} people, {one.together.size:,} delays, {one.left_out} rows left out"
    return f"{one.source}: {n} ({one.licence})"


def _answer(judged: Delays, sets: Sequence[Delays]) -> str:
    """Return the page's answer in three sentences."""
    gamma = fit_of(judged.fits_together, GAMMA.name).parameters
    quick = " and ".join(f"{np.median(one.together):.2f} s ({one.name})" for one in sets if one is not judged)
    return (
        f"**In short.** Judging takes longer than reacting: {np.median(judged.together):.2f} s in the "
        f"median, against {quick}. A gamma of all evaluations has shape {gamma['shape']:.2f} and scale "
        f"{gamma['scale_s']:.2f} s; the paper's are 2.5 and 0.3 s. The person explains "
        f"{fractions_of_variance(judged)['person']:.0%} of the variance of log delays; most of it is from "
        "press to press."
    )


def _in_short(
    sets: Sequence[Delays], judged: Delays, values: Sequence[OfValue], credit: Sequence[CreditOnTarget]
) -> str:
    quick = [one for one in sets if one is not judged]
    sizes = sorted({abs(one.value) for one in values})
    strong, weak = _of_size(values, sizes[-1]), _of_size(values, sizes[0])
    gamma = fit_of(judged.fits_together, GAMMA.name).parameters
    fractions = fractions_of_variance(judged)
    own_others = _difference(credit, OWN, OTHERS)
    own_paper = _difference(credit, OWN, PAPER)
    times = " and ".join(f"{np.median(one.together):.2f} s ({one.name})" for one in quick)
    return "\n".join(
        [
            (
                f"- An evaluation takes {np.median(judged.together):.2f} s in the median, a reaction {times}."
                " Simple reactions do not tell the delay of evaluations."
            ),
            (
                f"- A gamma of all evaluations has shape {gamma['shape']:.2f} and scale "
                f"{gamma['scale_s']:.2f} s: the paper's shape of 2.5 is right in kind, its scale of 0.3 s is "
                "too short here."
            ),
            (
                f"- People differ: their medians go from {judged.medians.min():.2f} to "
                f"{judged.medians.max():.2f} s. Still the person explains only {fractions['person']:.0%} of "
                f"the variance of log delays, and the value {fractions['value']:.0%} more; the rest is from "
                "press to press."
            ),
            (
                f"- Strong evaluations are quick: {strong:.2f} of a person's usual delay for values of"
                f" {sizes[-1]:g}, {weak:.2f} for {sizes[0]:g}."
            ),
            (
                f"- With steps of {MIDDLE_STEP_S:g} s, a gamma fitted to the person gives the judged step "
                f"{_words(own_others)} more of the credit than one fitted to all others, and "
                f"{_words(own_paper)} more than the paper's density."
            ),
        ]
    )


def _of_size(values: Sequence[OfValue], size: float) -> float:
    """Return the geometric mean ratio of the values of one size, weighted by people."""
    some = [one for one in values if abs(one.value) == size]
    weights = [one.people for one in some]
    return float(np.exp(np.average([np.log(one.ratio) for one in some], weights=weights)))


def _together_table(sets: Sequence[Delays]) -> str:
    rows = []
    for one in sets:
        x = one.together
        gamma, shifted = (fit_of(one.fits_together, f.name).parameters for f in (GAMMA, SHIFTED_GAMMA))
        rows.append(
            [
                f"{one.name}, {len(one.times_s)} people",
                *(f"{q:.2f}" for q in np.quantile(x, (0.05, 0.25, 0.5, 0.75, 0.95))),
                f"{x.mean():.2f}",
                f"{x.std(ddof=1):.2f}",
                f"{gamma['shape']:.2f}, {gamma['scale_s']:.3f}",
                f"{shifted['shape']:.2f}, {shifted['scale_s']:.3f}, {shifted['offset_s']:.3f}",
                one.fits_together[0].family,
            ]
        )
    head = ["task", "5 % (s)", "25 %", "50 %", "75 %", "95 %", "mean", "sd", "gamma: shape, scale (s)"]
    return _table([*head, "shifted gamma: shape, scale, offset (s)", "best family"], rows)


def _people_table(sets: Sequence[Delays]) -> str:
    rows = []
    for one in sets:
        low, middle, high = np.quantile(one.medians, (0.25, 0.5, 0.75))
        first, last = np.quantile(one.medians, (0.1, 0.9))
        rows.append(
            [
                one.name,
                f"{np.median([x.size for x in one.times_s.values()]):.0f}",
                f"{one.medians.min():.2f}",
                f"{low:.2f}, {middle:.2f}, {high:.2f}",
                f"{one.medians.max():.2f}",
                f"{last / first:.2f}",
                f"{fractions_of_variance(one)['person']:.0%}",
                _quartiles(one.shapes(GAMMA.name)),
                _quartiles(one.shapes(SHIFTED_GAMMA.name)),
            ]
        )
    head = [
        "task",
        "delays each",
        "lowest median (s)",
        "quartiles of medians",
        "highest",
        "90 % by 10 % of medians",
    ]
    return _table(
        [*head, "variance between people", "gamma's shape: quartiles", "shifted gamma's shape"], rows
    )


def _quartiles(x: NDArray[np.float64]) -> str:
    return ", ".join(f"{q:.1f}" for q in np.quantile(x, (0.25, 0.5, 0.75)))


def _best_words(one: Delays) -> str:
    return f"{one.name} " + ", ".join(f"{family} {n}" for family, n in one.best().most_common(4))


def _value_table(values: Sequence[OfValue]) -> str:
    rows = [
        [
            f"{one.value:+g}" if one.value else "0",
            f"{one.n:,}",
            *(f"{q:.2f}" for q in one.quantiles_s),
            (
                f"{one.ratio:.2f} ({np.exp(np.log(one.ratio) - 1.96 * one.ratio_se):.2f} to "
                f"{np.exp(np.log(one.ratio) + 1.96 * one.ratio_se):.2f})"
            ),
            str(one.people),
        ]
        for one in values
    ]
    return _table(
        ["value", "evaluations", "5 % (s)", "50 %", "95 %", "by the person's usual delay", "people"], rows
    )


def _value_words(judged: Delays, values: Sequence[OfValue]) -> str:
    fractions = fractions_of_variance(judged)
    plus = [one for one in values if one.value > 0]
    minus = [one for one in values if one.value < 0]
    pairs = "; ".join(
        f"{-m.value:g}: {m.ratio:.2f} for bad and {p.ratio:.2f} for good"
        for m in minus
        for p in plus
        if m.value == -p.value
    )
    return (
        "*By the person's usual delay*: geometric mean over people of the person's delay at this value by "
        "that at all values, with a 95 % interval over people. The size of the value matters, its sign does "
        f"not ({pairs}). Within people the value explains "
        f"{fractions['value'] / (1.0 - fractions['person']):.0%} of the variance of log delays."
    )


def _credit_words() -> str:
    return (
        "The share of a press's credit that reaches the step in which the judged thing happened. Steps"
        " follow each other without gaps; what is judged happens anywhere in its step. People with at least"
        f" {FEWEST} delays; each half of their delays is scored with the fit of the other half, and what is"
        " common to people is fitted to the others only. Means over people; the difference to *one gamma of"
        f" all others* has a 95 % bootstrap interval over people (root seed {ROOT_SEED})."
    )


def _credit_table(found: Sequence[CreditOnTarget]) -> str:
    rows = []
    for one in found:
        difference = "" if one.rule == OTHERS else _words(_difference(found, one.rule, OTHERS))
        rows.append([one.rule, *(f"{one.share[step_s].mean():.3f}" for step_s in STEPS_S), difference])
    return _table(
        ["density", *(f"steps of {s:g} s" for s in STEPS_S), f"difference at {MIDDLE_STEP_S:g} s"], rows
    )


def _difference(found: Sequence[CreditOnTarget], rule: str, control: str) -> Interval:
    by_rule = {one.rule: one.share[MIDDLE_STEP_S] for one in found}
    return paired_difference(by_rule[rule], by_rule[control], rng=stream(ROOT_SEED, f"delays page {rule}"))


def _words(found: Interval) -> str:
    return f"{found.estimate:+.3f} ({found.low:+.3f} to {found.high:+.3f})"


def _own_words(sets: Sequence[Delays], credit: dict[str, list[CreditOnTarget]], judged: Delays) -> str:
    gains = ", ".join(f"{_words(_difference(credit[one.name], OWN, OTHERS))} ({one.name})" for one in sets)
    value = _words(_difference(credit[judged.name], BY_VALUE, OWN))
    return (
        f"Knowing the person: {gains}, for steps of {MIDDLE_STEP_S:g} s. Knowing the value's size beyond the"
        f" person: {value}. A density that is narrower and earlier than the delays can reach as much credit"
        " as a true one, because it bets on the quick presses; it misplaces the slow ones entirely."
        " Reactions are placed far better than evaluations under every rule: the spread from press to press,"
        " which no fit removes, is what limits credit."
    )


def _onset_words(found: Sequence[CreditOnTarget]) -> str:
    shares = {one.rule: one.share[MIDDLE_STEP_S].mean() for one in found}
    words = ", ".join(f"{share:.2f} ({rule})" for rule, share in shares.items())
    return (
        "If people judge a step by its appearance (u = 0) rather than by something inside it, a true density"
        " gives at most half of the credit to that step on average, however long it is: half of the density"
        " lies at longer delays than the one at hand, and that mass goes to steps before. Evaluations, steps"
        f" of {MIDDLE_STEP_S:g} s: {words}. Section 3.3 integrates over the whole time on screen, hence"
        " assumes that what is judged may come at any moment of it."
    )


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(cells) + " |" for cells in lines)


def figure(sets: Sequence[Delays], judged: Delays) -> "Figure":
    """Draw pooled delays with the paper's density, people's medians, and evaluations by value."""
    from matplotlib.figure import Figure

    from studies.reaction_time.families import distribution
    from studies.reaction_time.figures import COLORS, LINES

    drawn = Figure(figsize=(11.0, 3.6))
    drawn.subplots_adjust(left=0.06, right=0.99, bottom=0.16, top=0.9, wspace=0.25)
    left, middle, right = drawn.subplots(1, 3)
    time_s = np.linspace(0.0, 4.0, 801)
    for i, one in enumerate(sets):
        edges = np.arange(0.0, 4.05, 0.05)
        heights = np.histogram(one.together, bins=edges)[0] / (one.together.size * 0.05)
        left.stairs(heights, edges, color=COLORS[i], alpha=0.5)
        density = distribution(fit_of(one.fits_together, SHIFTED_GAMMA.name)).pdf(time_s)
        left.plot(time_s, density, color=COLORS[i], linestyle=LINES[i], label=one.name)
    paper = time_s**1.5 * np.exp(-time_s / 0.3) / (1.329340388179137 * 0.3**2.5)
    left.plot(time_s, paper, color="black", linestyle=":", label="paper: gamma(2.5, 0.3)")
    left.set(xlabel="delay (s)", ylabel="density (per second)", title="all delays, shifted gammas")
    left.legend(frameon=False)
    for i, one in enumerate(sets):
        fraction = (np.arange(one.medians.size) + 0.5) / one.medians.size
        middle.step(np.sort(one.medians), fraction, color=COLORS[i], linestyle=LINES[i], label=one.name)
    middle.set(xlabel="a person's median delay (s)", ylabel="share of people", title="from person to person")
    middle.legend(frameon=False)
    values = by_value(judged)
    for of_value in values:
        right.plot([of_value.value] * 2, of_value.quantiles_s[::2], color="0.7")
        right.plot(of_value.value, of_value.quantiles_s[1], "o", color=COLORS[0])
    right.set(xlabel="value given", ylabel="delay (s)", title="evaluations: median, 5 to 95 %")
    right.set_xticks([of_value.value for of_value in values])
    return drawn


def main(arguments: Sequence[str] | None = None) -> None:
    """Make the page; see the module."""
    from studies.reaction_time.figures import save

    parser = argparse.ArgumentParser(prog="python -m studies.evaluations.delays_page", description=__doc__)
    parser.add_argument("docs", type=Path, help="folder of the documentation")
    parser.add_argument("--data", type=Path, help="folder of real data; ARL_DATA without it")
    given = parser.parse_args(arguments)
    data = given.data or (Path(os.environ["ARL_DATA"]) if os.environ.get("ARL_DATA") else None)
    if data is None:
        parser.error("name the folder of real data: --data FOLDER, or set ARL_DATA")
    try:
        judged = evaluations(data)
        sets = [*reactions(data), judged]
    except (OSError, ValueError) as error:
        parser.error(str(error))
    for folder in (given.docs / "results", given.docs / "figures"):
        folder.mkdir(parents=True, exist_ok=True)
    (given.docs / "results" / "delays.md").write_text(page(sets, judged), encoding="utf-8")
    save(figure(sets, judged), given.docs / "figures", "delays")


if __name__ == "__main__":
    main()
