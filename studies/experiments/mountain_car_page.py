"""The page of Mountain Car: steps to the flag by condition, and what the literature says of the same."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from core.numerics.arrays import Floats
from studies.comparison import Verdict
from studies.experiments import page
from studies.experiments.page import Page
from studies.experiments.results import Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BLOCK = 5
"""Episodes of a point of a curve."""
FIRST = 20
"""Episodes in which a participant matters most: given beside the whole trial."""
CLAIMS = (
    ("action-biasing", "sarsa", "action biasing learns faster than Sarsa (Knox, Setapen & Stone 2011)"),
    (
        "control-sharing",
        "sarsa",
        "control sharing learns faster than Sarsa (a technique of Knox & Stone 2010)",
    ),
    ("annealed", "sarsa", "the annealed scheme learns faster than Sarsa (Sridharan & Aerolla 2011)"),
    ("linear", "sarsa", "the linear scheme with Eq. 4 learns faster than Sarsa (Sridharan & Aerolla 2011)"),
    (
        "linear",
        "annealed",
        "the linear scheme with Eq. 4 does better than the annealed one (Sridharan & Aerolla 2011)",
    ),
    ("shaping", "sarsa", "reward shaping learns faster than Sarsa (a technique of Knox & Stone 2010)"),
    (
        "action-biasing",
        "shaping",
        "action biasing does better than reward shaping (no source at hand ranks them)",
    ),
)
"""(better, worse, in words); chosen before the trials were played."""
OTHERS = (
    ("q-augmentation", "sarsa"),
    ("human-only", "sarsa"),
    ("linear-equation-5", "sarsa"),
    ("linear-fixed", "sarsa"),
    ("linear-sparing", "sarsa"),
    ("shaping-ten", "sarsa"),
    ("linear", "linear-equation-5"),
    ("linear-fixed", "linear"),
)
HOW_TO_READ = """\
Trials pair by seed: the same starts for every condition. Brackets hold 95 % bootstrap intervals (percentile, 10,000 resamples).
*Ratio*: geometric mean over pairs of the second condition's steps / the first one's: above 1 the first is faster.
*Difference*: steps that the first saves. *P(improvement)*: a random trial of the first is faster than a random trial of the second.
*p*: two-sided, 20,000 random sign flips of the logarithms; *Holm*: corrected for all rows of the table.
"""  # noqa: E501
LITERATURE = """\
## What is published, and what differs

| source | setting | said | here |
| --- | --- | --- | --- |
| Sutton & Barto 2018, example 10.1, figures 10.2 and 10.4 | one-step and n-step Sarsa, 8 joint tilings of 8 x 8, alpha 0.5 / 8, no exploration, values from 0 | the axis of figure 10.4: means of 220 to 300 steps over the first 50 episodes, over step sizes and n | {sarsa} |
| Knox & Stone 2010 (AAMAS) | eight ways of combining a human model with Sarsa(lambda); the model was taught before | better final performance and better cumulative performance than either the human model or Sarsa alone | against Sarsa: {knox}; against the human model alone: {alone} |
| Knox, Setapen & Stone 2011 (AAAI spring symposium) | Mountain Car; human model and Sarsa learn at the same time; two algorithms | one of them, action biasing, consistently improves on Sarsa alone | {biasing} |
| Knox & Stone 2011 (ICML workshop) | the four techniques that had succeeded in 2010, on a second task, in sequence and at the same time | how sensitive they are to their parameters | not compared |
| Griffith et al. 2013 | Advise against other ways of using feedback | Advise can do better, and stands infrequent and inconsistent feedback | not played |

**What the sources support.** Of the publications of Knox and colleagues the abstracts were at hand, and the program that they released
(bradknox/tamerproject); of Griffith et al. the first page. None of these says by how much a technique is better, nor, as far as we could
read, which of the eight were the four that succeeded: that these were reward shaping, Q augmentation, action biasing and control sharing,
and that acting on the choice (biasing, sharing) was found to be better than acting on the reward, is what we remember, and is compared
above without a source. Sutton & Barto's settings are those of a public program that draws the book's figures
(ShangtongZhang/reinforcement-learning-an-introduction, chapter10/mountain_car.py), and so is that axis; the figures themselves were not at
hand.

**Where our set-up departs.**

- From the book: traces with lambda = 0.9, where figure 10.2 has one-step targets; an episode is broken off after 1000 steps; positions
  are tiled to 0.6, as Gymnasium bounds them, where the book's track ends at the flag, 0.5.
- From Knox & Stone 2010: joint tiles, where their program has 40 x 40 radial basis functions, alpha 0.15, lambda 0.84, exploration
  0.00625, and values from -10; a simulated teacher, where they had people; and a human model that learns while Sarsa does.
- The influence of the human model falls by 0.98 an episode, as in their program. Its weight of 10 on raw values belongs to their trainers'
  H: a press of ours is 1, and a simulated teacher contradicts itself in one press of ten only.
- Against the human model alone (TAMER) our combinations end better, and are worse over the whole trial: our teacher knows from the
  first press a policy that needs 124 steps, and Sarsa has to unlearn its optimistic values first.
"""  # noqa: E501
NEGATIVE = """\
## What a negative performance does

The reward is -1 a step, so an episode's performance is minus its number of steps. Eq. 4 divides by a sum of performances and would turn a match
into its opposite. Here an episode counts by how far its performance lies above the lowest of those compared; the lowest counts nothing, and
where all are equal all count alike. The probability of playing a policy again goes by the same weights. Eq. 5 has two episodes, of which the
worse would count nothing however little it is worse: where one of them is negative, both count alike. Correlations of ranks need no
change. (`core.combination.trust.measures`, `as_weights`.) Mean trust over the last {last} episodes: Eq. 4 {eq4}, Eq. 5 {eq5}.
"""  # noqa: E501


def scores(results: Results, episodes: int | None = None) -> dict[str, Floats]:
    """Return mean steps per episode of each trial, by the condition's label; of the first `episodes` only."""
    return {
        results.label(name): results.table(name, "steps")[:, :episodes].mean(axis=1)
        for name in results.conditions
    }


def last_block(results: Results) -> dict[str, Floats]:
    """Return mean steps of each trial's last `FIRST` episodes, by the condition's label."""
    return {
        results.label(name): results.table(name, "steps")[:, -FIRST:].mean(axis=1)
        for name in results.conditions
    }


def report_page(results: Results) -> Page:
    """Return the page of the experiment."""
    whole, there = scores(results), set(results.conditions)
    claimed = [claim for claim in CLAIMS if {claim[0], claim[1]} <= there]
    verdicts = [_faster(results, better, worse, whole) for better, worse, _ in claimed]
    verdicts += [_faster(results, a, b, whole) for a, b in OTHERS if {a, b} <= there]
    held = {
        (better, worse): page.held(verdict)
        for (better, worse, _), verdict in zip(claimed, verdicts, strict=False)
    }
    name, seeds = results.experiment.name, len(results.seeds)
    text = f"""\
# {results.experiment.title}

{page.claims_table("claim", [words for *_, words in claimed], verdicts[: len(claimed)])}
![Steps to the flag](../figures/{name}.png)

Means over {seeds} trials with 95 % bootstrap bands, in blocks of {BLOCK} episodes. A simulated teacher watches every episode at 150 ms
a step and presses about 24 times a minute, as the people of TAMER's public logs did; one press in ten is wrong. No setting was tuned: all are
published or are defaults of this program. One trial of three conditions, at a root seed kept for pilots (900,000), was played to see that it
runs; after it Q augmentation and the human model alone were added, and no setting was changed.

## Scores

The score of a trial is the mean number of steps of its episodes: the area under its learning curve; fewer are better. It was chosen
before the trials were played.

{page.summary_table(whole, "steps per episode, over the whole trial")}
First {FIRST} episodes:

{page.summary_table(scores(results, FIRST), "steps per episode")}
Last {FIRST} episodes:

{page.summary_table(last_block(results), "steps per episode")}
## Comparisons

{HOW_TO_READ}
{page.verdict_table(verdicts)}
{_literature(results, held)}
{_negative(results)}
## What the teacher did

{_teacher_table(results)}
{page.how_it_was_made(results)}"""  # noqa: E501
    return Page(name, text, {name: _figure(results)})


def _faster(results: Results, first: str, second: str, steps: dict[str, Floats]) -> Verdict:
    """Compare steps the other way round, so that more than 1 means that the first is faster."""
    found = page.verdict(results.label(second), results.label(first), steps)
    return Verdict(
        found.control,
        found.treated,
        found.ratio,
        found.difference,
        found.improvement,
        found.effect_size,
        found.p,
        found.p_holm,
    )


def _literature(results: Results, held: Mapping[tuple[str, str], str]) -> str:
    def said(*claims: tuple[str, str]) -> str:
        return "; ".join(f"{better}: {held.get((better, worse), 'not played')}" for better, worse in claims)

    sarsa = "not played"
    if "sarsa" in results.trials:
        steps = results.table("sarsa", "steps")
        sarsa = (
            f"first episode {steps[:, 0].mean():.0f} steps, first {FIRST} {steps[:, :FIRST].mean():.0f}, all "
            f"{steps.shape[1]} {steps.mean():.0f}, last {FIRST} {steps[:, -FIRST:].mean():.0f}"
        )
    return LITERATURE.format(
        sarsa=sarsa,
        knox=said(*((name, "sarsa") for name in ("shaping", "action-biasing", "control-sharing"))),
        biasing=said(("action-biasing", "sarsa")),
        alone=_against_the_model(results),
    )


def _against_the_model(results: Results) -> str:
    """Return which combinations did better than the human model alone, at the end and over the whole
    trial.
    """
    names = ("shaping", "action-biasing", "control-sharing")
    if not {*names, "human-only"} <= results.trials.keys():
        return "not played"
    whole = {name: float(results.table(name, "steps").mean()) for name in (*names, "human-only")}
    end = {name: float(results.table(name, "steps")[:, -FIRST:].mean()) for name in whole}
    better = [sum(of[name] < of["human-only"] for name in names) for of in (end, whole)]
    return f"{better[0]} of 3 end better, {better[1]} of 3 are better over the whole trial"


def _negative(results: Results) -> str:
    def trust(name: str) -> str:
        there = name in results.trials
        return f"{results.table(name, 'trust')[:, -FIRST:].mean():.2f}" if there else "not played"

    return NEGATIVE.format(last=FIRST, eq4=trust("linear"), eq5=trust("linear-equation-5"))


def _teacher_table(results: Results) -> str:
    rows = []
    for name in results.conditions:
        steps, presses = results.table(name, "steps"), results.table(name, "presses")
        rows.append(
            [
                results.label(name),
                page.number(float(presses.mean())),
                page.number(float(presses.sum(axis=1).mean())),
                page.number(float(results.table(name, "w_h").mean())),
                f"{100 * (1 - results.table(name, 'reached').mean()):.1f} %",
                page.number(float(steps.sum(axis=1).mean()) * 0.15 / 60),
            ]
        )
    header = [
        "condition",
        "presses per episode",
        "per trial",
        "mean w_h",
        "episodes broken off",
        "minutes on screen",
    ]
    return page.table(header, rows)


def _figure(results: Results) -> Figure:
    """Draw steps per episode, and beside them w_h, in blocks."""
    figure = page.new_figure(7.2, 4.2)
    left, right = figure.subplots(1, 2)
    blocks = {results.label(name): results.blocks(name, "steps", BLOCK) for name in results.conditions}
    x = np.arange(1, next(iter(blocks.values())).shape[1] + 1) * float(BLOCK)
    page.draw_curves(left, x, blocks)
    left.set(xlabel="episodes", ylabel="steps to the flag", yscale="log")
    trusting = [name for name in results.conditions if name.startswith("linear")]
    page.draw_curves(
        right, x, {results.label(name): results.blocks(name, "trust", BLOCK) for name in trusting}
    )
    right.set(xlabel="episodes", ylabel="trust in the teacher, $w_h$")
    if trusting:
        right.legend(frameon=False, fontsize="x-small")
    figure.legend(
        *left.get_legend_handles_labels(),
        loc="outside lower center",
        ncols=3,
        frameon=False,
        fontsize="small",
    )
    return figure
