"""The page of the robustness experiment: the goal and whether it was reached, every rule at every rate, every
person.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from core.numerics.arrays import Floats
from studies.comparison import Verdict
from studies.experiments import page
from studies.experiments.page import Page
from studies.experiments.rates import (
    AtRate,
    ByRule,
    in_short,
    rates_figure,
    ratios_table,
    summary,
    weights_table,
)
from studies.experiments.results import Results
from studies.experiments.robustness_settings import (
    ENVIRONMENT,
    FRESH,
    FRESH_ENVIRONMENT,
    GRADIENT,
    MARGIN,
    PEOPLE,
    RATES,
    TRUST,
    by_rate,
)
from studies.experiments.tetris_pages import SCORE, same_trials

RULES: dict[str, str] = {
    MARGIN: "signed agreement with a margin (ours)",
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
DRAWN = (MARGIN, "tried", "eq4", "annealed", "constant")
"""Rules in the figure, which more would make unreadable."""


WHY = """\
## The rule

    b_i, c_i   fraction of the decisions in episode i at which the environment's policy chose the human model's best, or worst, action
    a_i        = b_i - c_i, the signed agreement, in [-1, 1]
    w          = sum(pm_i a_i) / sum(pm_i) over the last 200 episodes (Eq. 4 with a_i; pm_i: lines cleared)
    se         = sd(a) sqrt(sum pm_i^2) / sum pm_i
    w_h        = 2 sign(w) max(0, |w| - 2 se - 0.1)

**Why it works.** What an agent can know of a person without any question is whether policies that do well do what the person praises, or what the
person blames. Of two unrelated policies, one chooses the other's best action as often as its worst, whatever their quality: the difference is 0 for a useless participant, where the
rate of equal choices (Eq. 4) is 0.15 to 0.2. An adversary's is negative, so what they say can be turned round and used. The margin is for
what no error bar over episodes shows: a human model learned from noise is *one* random policy, the same in all episodes, and agrees with good policies by a fixed
number of 0.05 to 0.16 either way. Below margin and error w_h is exactly 0, and the session is the environment's own, decision by decision.

**When it fails.** (1) It is late: until the search has found something, its policies agree with nobody, and w_h stays 0 in the first two iterations or so. Eq. 4, which believes
everybody a little at first, does better where people are good, and worse where they are not. (2) Where good policies do not do what good people praise, agreement
misleads: early Sarsa in Keepaway is such a case ([there](robustness-keepaway.md), with the rule that does better). (3) The margin belongs to the number of actions and of features: where unrelated
policies agree by more, it must be larger. (4) A participant who changes sides is found out only as fast as the human model forgets, which it does not. (5) Agreement is not use: a participant
who judges the immediate effect alone (*myopic*, below) is listened to and gives nothing, and over the policy gradient 30 % wrong are believed without a gain that 20 trials would show.

Another rule, *trust by trial*, tries a person's word out in some episodes and goes by lines cleared ([why, and how](../decisions/tried-trust.md)).
"""  # noqa: E501
"""What the page says of the rule whatever came out."""


def robustness_page(results: Results) -> Page:
    """Return the page."""
    scores = {name: results.table(name, "lines").mean(axis=1) for name in results.conditions}
    against = _against_the_environment(results.conditions, scores)
    by_rule = _by_rule(results, against)
    drawn = {RULES[rule]: by_rule[RULES[rule]] for rule in DRAWN if RULES[rule] in by_rule}
    shared, others = same_trials(
        results, "fig5", "Fig. 5", {ENVIRONMENT: "ce", "eq4-010": "arl-ce", "annealed-010": "annealed"}
    )
    text = f"""\
# {results.experiment.title}

{in_short(by_rule, RULES[MARGIN], "the environment alone")}
A person presses the wrong key in 0 to 100 % of the cases: from a perfect judge by way of pure noise (50 %) to a perfect adversary. Scores
are {SCORE}; ratios are to the environment alone, the same learner without a person, over {len(results.seeds)} paired trials. ({shared})

![Five rules at every rate](../figures/robustness.png)

Five of the rules; where a line leaves the picture, the table below has its end.

## The goal, and whether the rule reached it

One rule, its constants fixed in advance on other seeds ([a margin of agreement](../decisions/margin-of-agreement.md)). It is judged on root seeds from {FRESH} on,
which nobody had looked at under any rule, against the environment alone and annealed on the same seeds.

{_goal(scores, against)}
{WHY}
{_every_rule(by_rule, scores)}
## Simulated people by name

The rule, over the cross-entropy method, with the people of `core.feedback.simulated_participants`, 1 press in 10 wrong unless the name says otherwise; on the fresh seeds. (Expert, noisy,
useless and adversary are the rates above. The same people over Sarsa: [Keepaway](robustness-keepaway.md).)

{_people_table(results, against)}
## Another learner: policy gradient

{_gradient_table(results, scores)}
## How to read this

{page.HOW_TO_READ}
{page.how_it_was_made(results, others=others)}"""  # noqa: E501
    return Page("robustness", text, {"robustness": rates_figure(drawn, RATES)})


def _every_rule(by_rule: ByRule, scores: Mapping[str, Floats]) -> str:
    """Return the section with ratios, weights and scores of every rule at every rate."""
    return f"""\
## Every rule at every rate

Ratio to the environment alone, with 95 % interval. (Ours: on its fresh seeds; the others on root seeds that had been looked at, under these rules, when ours was
fixed.)

{ratios_table(by_rule, RATES)}
{summary(by_rule)}
Mean weight of the participant over the last 100 episodes:

{weights_table(by_rule, RATES)}
Mean scores (arithmetic), {SCORE}:

{_scores_table(scores)}"""  # noqa: E501


def _against_the_environment(conditions: Iterable[str], scores: Mapping[str, Floats]) -> dict[str, Verdict]:
    """Return how each condition compares with the environment alone on its own seeds."""
    found = {}
    for name in conditions:
        fresh = name.startswith((f"{MARGIN}-", "person-", "fresh-"))
        alone = FRESH_ENVIRONMENT if fresh else ENVIRONMENT
        if name not in (alone, GRADIENT) and not name.startswith("gradient-") and alone in scores:
            found[name] = page.verdict(name, alone, scores)
    return found


def _goal(scores: Mapping[str, Floats], against: Mapping[str, Verdict]) -> str:
    """Return each demand of the goal with what was found."""
    rows = []
    reached: list[str] = []
    missed: list[str] = []
    for rate, name in by_rate(MARGIN, against).items():
        found = against[name]
        mean_ratio = float(scores[name].mean() / scores[FRESH_ENVIRONMENT].mean())
        # By either measure: the interval and the test need not agree.
        harmless = not (found.ratio.high < 1 or (found.p < 0.05 and found.ratio.estimate < 1))
        near = found.ratio.estimate >= 0.9
        demands = [("never significantly below", harmless), ("nor 10 % below", near)]
        if rate in (10, 30):
            demands.append(("beats the environment at 95 %", found.ratio.low > 1))
            annealed = f"fresh-annealed-{rate:03d}"
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
    if not rows:
        return "These trials were not played.\n"
    summary = f"Every demand is met at {', '.join(reached) or 'no rate'}"
    if missed:
        summary += f"; **not all at {', '.join(missed)}**, so the goal as a whole is not reached"
    return f"{summary}.\n\n{page.table(columns, rows)}"


def _by_rule(results: Results, against: Mapping[str, Verdict]) -> ByRule:
    """Return what came of each rule that was played, by its label and the rate."""
    found = {}
    for rule, label in RULES.items():
        cells = {
            rate: AtRate(against[name].ratio, float(results.table(name, "w_h")[:, -100:].mean()))
            for rate, name in by_rate(rule, against).items()
        }
        if cells:
            found[label] = cells
    return found


def _scores_table(scores: Mapping[str, Floats]) -> str:
    alone = scores[ENVIRONMENT].mean()
    rows = [["environment only", *(page.number(float(alone)) for _ in RATES)]]
    if FRESH_ENVIRONMENT in scores:
        fresh = page.number(float(scores[FRESH_ENVIRONMENT].mean()))
        rows.append(["environment only, fresh seeds", *(fresh for _ in RATES)])
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


def _gradient_table(results: Results, scores: Mapping[str, Floats]) -> str:
    people = {f"{GRADIENT}-{rate:03d}": f"{rate} % wrong" for rate in RATES}
    people |= {f"{GRADIENT}-{name}": name for name in PEOPLE}
    if GRADIENT not in scores or not people.keys() & scores.keys():
        return "These trials were not played.\n"
    rows, below, above = [], [], []
    for name, participant in people.items():
        if name in scores:
            found = page.verdict(name, GRADIENT, scores)
            below += [participant] if found.ratio.high < 1 else []
            above += [participant] if found.ratio.low > 1 else []
            weight = results.table(name, "w_h")[:, -100:].mean()
            rows.append([participant, page.interval(found.ratio), page.p_value(found.p), f"{weight:.2f}"])
    told = (
        f"Significantly below policy gradient alone with: {', '.join(below) or 'nobody'}. Significantly "
        f"above it with: {', '.join(above) or 'nobody'}."
    )
    table = page.table(["person", "ratio to policy gradient alone", "p", "w_h at the end"], rows)
    return f"The same rule, its constants as they are. {told}\n\n{table}"
