"""The page of the robustness experiment: the goal and whether it was reached, every rule at every rate, every person."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from studies.comparison import Verdict
from studies.experiments import page
from studies.experiments.page import Page
from studies.experiments.results import Results
from studies.experiments.robustness import ENVIRONMENT, GRADIENT, PEOPLE, RATES, TRUST, by_rate
from studies.experiments.tetris_pages import SCORE, same_trials
from studies.reaction_time.figures import COLORS, LINES

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]

RULES: dict[str, str] = {
    "tried": TRUST["tried"][0],
    "signed": TRUST["signed"][0],
    "eq4": TRUST["eq4"][0],
    "annealed": "annealed",
    "constant": "constant, w_h = 1",
    "eq5": TRUST["eq5"][0],
    "chance": TRUST["chance"][0],
    "rank": TRUST["rank"][0],
    "rank-signed": TRUST["rank-signed"][0],
}
"""Rules in the order of tables, with their labels."""


WHY = """\
## The rule

    y_t        the t-th press, 1 or -1; its usual value so far: mean of y_1 .. y_(t-1)
    h_t        what the human model foresaw of it, learned from presses 1 .. t-1; its usual value and spread likewise
    g_t        = clip((h_t - usual h) / spread, -1, 1) (y_t - usual y)
    score      = sum g_t / sqrt(sum g_t^2)
    attitude   in {-1, 0, 1}; another one is tried in 30 % of the episodes while it is 0 and score > 2, and taken over when its
               episodes among the last 200 rank above the present one's by 3 standard errors; 5 % controls while it is not 0
    w_h        = attitude (Eq. 3 with w_r = 1, both sides standardised)

**Why it works.** Somebody useless, somebody good and an adversary differ in two ways, and no single measure tells all three apart. Random
presses cannot be foreseen, whatever is pressed more often: given the past, every g_t has mean 0, so the score is a martingale over the root
of its quadratic variation and seldom leaves a few standard errors. Good people and adversaries are foreseen equally well; which they are is
tried out, because a human model that helps shows at once in lines cleared, long before the search has found policies that could agree with it.
Where nothing is tried, w_h is exactly 0 and the session is the environment's own.

*Agreement* (Eq. 4, the signed match) has neither property. A human model learned from noise is one random policy in all episodes: its agreement
with good policies is a fixed number other than 0, and an error bar over episodes cannot see that.

**When it fails.** (1) Presses so unreliable that foreseeing them takes hundreds (30 % wrong at two presses per episode): they are heard when most
of what they could give is gone. (2) Policies adapt to the human model they are played with, so controls without it flatter listening: a human
model that helped at first and holds the search back later is not dropped. (3) A person who is consistent about what does not matter passes the
first test, and is left to the second. (4) Somebody who changes sides is found out only by performance, since the human model keeps what it
learned.
"""
"""What the page says of the rule whatever came out."""


def robustness_page(results: Results) -> Page:
    """Return the page."""
    scores = {name: results.table(name, "lines").mean(axis=1) for name in results.conditions}
    against = {
        name: page.verdict(name, ENVIRONMENT, scores)
        for name in results.conditions
        if name not in (ENVIRONMENT, GRADIENT) and not name.startswith("gradient-")
    }
    shared, others = same_trials(
        results, "fig5", "Fig. 5", {ENVIRONMENT: "ce", "eq4-010": "arl-ce", "annealed-010": "annealed"}
    )
    text = f"""\
# {results.experiment.title}

A person presses the wrong key in 0 to 100 % of the cases: from a perfect judge by way of pure noise (50 %) to a perfect adversary. Scores
are {SCORE}; ratios are to the environment alone, the same learner without a person, over {len(results.seeds)} paired trials. ({shared})

![Every rule at every rate](../figures/robustness.png)

## The goal, and whether the rule reached it

One rule, its constants fixed in advance on other seeds ([tried trust](../decisions/tried-trust.md)).

{_goal(scores, against)}
{WHY}
## Every rule at every rate

Ratio to the environment alone, with 95 % interval.

{_rules_table(against)}
Mean weight of the human over the last 100 episodes:

{_weights_table(results)}
Mean scores (arithmetic), {SCORE}:

{_scores_table(scores)}
## Every simulated person

The rule with people by name (`core.feedback.persons`), 1 press in 10 wrong unless the name says otherwise.

{_people_table(results, against)}
## Another learner: policy gradient

{_gradient_table(scores)}
## How to read this

{page.HOW_TO_READ}
{page.how_it_was_made(results, others=others)}"""
    return Page("robustness", text, {"robustness": _figure(results, scores, against)})


def _goal(scores: Mapping[str, Floats], against: Mapping[str, Verdict]) -> str:
    """Return each demand of the goal with what was found."""
    rows = []
    reached: list[str] = []
    missed: list[str] = []
    for rate, name in by_rate("tried", against).items():
        found = against[name]
        mean_ratio = float(scores[name].mean() / scores[ENVIRONMENT].mean())
        # By either measure: the interval and the test need not agree.
        harmless = not (found.ratio.high < 1 or (found.p < 0.05 and found.ratio.estimate < 1))
        near = found.ratio.estimate >= 0.9
        demands = [("never significantly below", harmless), ("nor 10 % below", near)]
        if rate in (10, 30):
            demands.append(("beats the environment at 95 %", found.ratio.low > 1))
            annealed = f"annealed-{rate:03d}"
            if annealed in scores:
                other = page.verdict(name, annealed, scores)
                demands.append(
                    (f"beats annealed at 95 % ({page.interval(other.ratio)})", other.ratio.low > 1)
                )
        if rate >= 80:
            demands.append(("better than the environment", found.ratio.estimate > 1))
            demands.append(("at 95 %", found.ratio.low > 1))
        (reached if all(met for _, met in demands) else missed).append(f"{rate} %")
        said = "; ".join(f"{what}: {'yes' if met else '**no**'}" for what, met in demands)
        rows.append(
            [f"{rate} %", page.interval(found.ratio), f"{mean_ratio:.2f}", page.p_value(found.p), said]
        )
    columns = ["wrong", "ratio to the environment", "ratio of plain means", "p", "demands"]
    summary = f"Every demand is met at {', '.join(reached) or 'no rate'}"
    if missed:
        summary += f"; **not all at {', '.join(missed)}**, so the goal as a whole is not reached"
    return f"{summary}.\n\n{page.table(columns, rows)}"


def _rules_table(against: Mapping[str, Verdict]) -> str:
    rows = []
    for rule, label in RULES.items():
        conditions = by_rate(rule, against)
        if not conditions:
            continue
        rows.append(
            [
                label,
                *(
                    page.interval(against[conditions[rate]].ratio) if rate in conditions else ""
                    for rate in RATES
                ),
            ]
        )
    return page.table(["rule", *(f"{rate} % wrong" for rate in RATES)], rows)


def _weights_table(results: Results) -> str:
    rows = []
    for rule, label in RULES.items():
        conditions = by_rate(rule, results.trials)
        if not conditions:
            continue
        cells = [
            f"{results.table(conditions[rate], 'w_h')[:, -100:].mean():.2f}" if rate in conditions else ""
            for rate in RATES
        ]
        rows.append([label, *cells])
    return page.table(["rule", *(f"{rate} %" for rate in RATES)], rows)


def _scores_table(scores: Mapping[str, Floats]) -> str:
    alone = scores[ENVIRONMENT].mean()
    rows = [["environment only", *(page.number(float(alone)) for _ in RATES)]]
    for rule, label in RULES.items():
        conditions = by_rate(rule, scores)
        if not conditions:
            continue
        rows.append(
            [
                label,
                *(
                    page.number(float(scores[conditions[rate]].mean())) if rate in conditions else ""
                    for rate in RATES
                ),
            ]
        )
    return page.table(["rule", *(f"{rate} %" for rate in RATES)], rows)


def _people_table(results: Results, against: Mapping[str, Verdict]) -> str:
    rows = [
        [
            name,
            page.interval(against[f"person-{name}"].ratio),
            page.p_value(against[f"person-{name}"].p),
            f"{results.table(f'person-{name}', 'w_h')[:, -100:].mean():.2f}",
            f"{results.table(f'person-{name}', 'presses').mean():.2f}",
        ]
        for name in PEOPLE
        if f"person-{name}" in against
    ]
    if not rows:
        return "These trials were not played.\n"
    return page.table(
        ["person", "ratio to the environment", "p", "w_h at the end", "presses per episode"], rows
    )


def _gradient_table(scores: Mapping[str, Floats]) -> str:
    names = [name for name in scores if name.startswith("gradient-")]
    if GRADIENT not in scores or not names:
        return "These trials were not played.\n"
    rows = []
    for name in names:
        found = page.verdict(name, GRADIENT, scores)
        rows.append([f"{int(name[-3:])} %", page.interval(found.ratio), page.p_value(found.p)])
    return page.table(["wrong", "ratio to policy gradient alone", "p"], rows)


def _figure(results: Results, scores: Mapping[str, Floats], against: Mapping[str, Verdict]) -> Figure:
    """Draw ratio and final weight against the rate, for the rules that were played at two rates or more."""
    figure = page.new_figure(7.2, 3.6)
    left, right = figure.subplots(1, 2)
    left.axhline(1.0, color="0.4", linewidth=1.0)
    shown = [rule for rule in RULES if len(by_rate(rule, against)) >= 2]
    for place, rule in enumerate(shown):
        conditions = by_rate(rule, against)
        rates = np.array(list(conditions), dtype=np.float64)
        found = [against[name].ratio for name in conditions.values()]
        middle = np.array([ratio.estimate for ratio in found])
        ends = np.array([[r.estimate - r.low for r in found], [r.high - r.estimate for r in found]])
        style = {
            "color": COLORS[place % len(COLORS)],
            "linestyle": LINES[place % len(LINES)],
            "marker": page.MARKERS[place % len(page.MARKERS)],
            "markersize": 4,
        }
        left.errorbar(rates + (place - 2) * 0.8, middle, yerr=ends, capsize=2, label=RULES[rule], **style)
        weights = [results.table(name, "w_h")[:, -100:].mean() for name in conditions.values()]
        right.plot(rates, weights, **style)
    left.set(xlabel="wrong presses (%)", ylabel="score / environment only", yscale="log", xticks=RATES)
    right.set(xlabel="wrong presses (%)", ylabel="$w_h$, last 100 episodes", xticks=RATES)
    ratios = (0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50)
    low, high = left.get_ylim()
    left.set_yticks([ratio for ratio in ratios if low <= ratio <= high])
    left.set_yticklabels([f"{ratio:g}" for ratio in ratios if low <= ratio <= high])
    left.set_yticks([], minor=True)
    for axes in (left, right):
        axes.grid(alpha=0.3)
    left.legend(frameon=False, fontsize="small")
    return figure
