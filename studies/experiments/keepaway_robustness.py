"""The Sarsa arm of robustness: wrong feedback against rules of trust, in Keepaway."""

from collections.abc import Iterator, Mapping

import msgspec

from core.combination.config import Annealed, Constant, Equation4, Equation5, SideBySide, Signed, Tried
from core.feedback.simulated_participants import persons
from core.keepaway.participant_config import KeepawayPersonConfig
from core.numerics.arrays import Floats
from studies.experiments import page
from studies.experiments.keepaway_pages import SCORES_TEXT, by_time, weights_used
from studies.experiments.keepaway_settings import DEPARTURES, arl, person, sarsa_alone
from studies.experiments.keepaway_trial import KeepawayTrial, quick, run_trial
from studies.experiments.page import Page
from studies.experiments.rates import AtRate, in_short, rates_figure, ratios_table, summary, weights_table
from studies.experiments.results import Results
from studies.experiments.sweep import Condition, Experiment

WRONG_PERCENT = (0, 10, 30, 50, 80, 100)
"""Share of presses of the wrong key."""
HOURS = 2.0
"""Shorter than Fig. 7: there are more than a hundred conditions, and people make their difference early."""


PEOPLE = ("lay", "hesitant", "instructed", "bursty", "hasty", "slow", "tiring", "leaves")
"""Simulated participants by name (`core.feedback.simulated_participants`) beside the rates. (There is no
*myopic* one: an option has no immediate effect.)"""
OURS = "side"
"""The rule that is for Sarsa (`docs/decisions/side-by-side.md`)."""
RANDOM_PERCENT = 50
"""Where presses say nothing."""
TRIED_ON_PEOPLE = (OURS, "margin", "constant", "tried")
"""Rules that they meet."""


def talkative(name: str) -> KeepawayPersonConfig:
    """Return a named participant who is as talkative as the participant of Fig. 7."""
    usual = person()
    trainer = msgspec.structs.replace(
        persons()[name],
        press_probability=usual.trainer.press_probability,
        max_presses=usual.trainer.max_presses,
        mean_presses=usual.trainer.mean_presses,
    )
    return msgspec.structs.replace(usual, trainer=trainer)


def _rules(participant: KeepawayPersonConfig) -> dict[str, tuple[str, KeepawayTrial]]:
    """Return name -> (label, trial) of every rule with this person."""
    return {
        OURS: ("learners side by side (ours)", arl(trust=SideBySide(), watched_by=participant, hours=HOURS)),
        "annealed": (
            "annealed, 0.98 per episode",
            arl(Annealed(per="episode"), watched_by=participant, hours=HOURS),
        ),
        "constant": ("constant w_h = 1", arl(Constant(), watched_by=participant, hours=HOURS)),
        "eq4": ("Eq. 4", arl(trust=Equation4(), watched_by=participant, hours=HOURS)),
        "eq5": ("Eq. 5", arl(trust=Equation5(), watched_by=participant, hours=HOURS)),
        "signed": ("signed agreement", arl(trust=Signed(), watched_by=participant, hours=HOURS)),
        "margin": (
            "signed agreement with a margin",
            arl(trust=Signed(margin=0.1), watched_by=participant, hours=HOURS),
        ),
        "tried": ("trust by trial", arl(trust=Tried(), watched_by=participant, hours=HOURS)),
    }


def _conditions() -> Iterator[Condition]:
    yield Condition("sarsa", "Sarsa", sarsa_alone(HOURS))
    for percent in WRONG_PERCENT:
        for name, (label, trial) in _rules(person(percent / 100)).items():
            yield Condition(f"{name}-{percent}", f"{label}, {percent} % wrong", trial)
    for participant in PEOPLE:
        rules = _rules(talkative(participant))
        for name in TRIED_ON_PEOPLE:
            label, trial = rules[name]
            yield Condition(f"{name}-{participant}", f"{label}, {participant}", trial)


EXPERIMENT = Experiment(
    name="robustness-keepaway",
    title="Wrong feedback and trust in Keepaway",
    conditions=tuple(_conditions()),
    trial=run_trial,
    quick=quick,
    departures=DEPARTURES,
)

DRAWN = (OURS, "tried", "eq4", "annealed", "constant")
"""Rules in the figure."""
WHY = """\
## Why most rules of trust misjudge people here, and what does not

*Agreement misleads.* Sarsa that has not learned yet passes in nearly every cycle, and keeps the ball longer so than by holding alone. Good people blame
most of these passes: they are right, and every measure of agreement with what the keepers do says that they are wrong.

*Single episodes mislead, too.* Sarsa's values belong to the policy that is played. An episode played under another w_h than those before it is played with
values that do not fit, and with a human model that was told of other situations: it is shorter with any participant. What listening is worth
shows only where keepers listen all the time, and learn so: that is the row of constant w_h ([measured on pilot seeds](../decisions/keepaway-experiments.md)).

*Any presses help a little.* Random presses (50 % wrong) make keepers better as well, by constant w_h and by trust by trial, whose mean w_h is near 0: young Sarsa
tries one action in a hundred, and gains from anybody's presses, because they make it try more. So what a rule makes of people is to be read against the column of 50 %, not against 1. By that measure
the constant weight uses people who know the game, and what it loses with an adversary is small.

*Learners side by side* ([the rule, and what was tried before it](../decisions/side-by-side.md)) compare keepers that learned with the participant and keepers that learned without: one learner chooses without the
participant, one believes them, one believes the opposite; one of them plays each episode, and all learn from it. So the one without the participant soon becomes better than Sarsa alone, from what
the others do, and then its agreement with the participant has the right sign. Its constants were fixed on pilot seeds.

**When it fails.** It takes some 200 episodes to decide, so people who are good gain less than if they were listened to from the start (constant w_h = 1), and a participant who leaves early leaves little. Its gain with random
presses is exploration, no trust. It needs a learner that can learn about one policy from the episodes of another, which is why it is not a rule for the cross-entropy method or
for on-line policy gradient; there, [signed agreement with a margin](robustness.md) is ours.

"""  # noqa: E501
"""What the page says of the rules whatever came out; found on pilot seeds."""


def _goal_table(scores: Mapping[str, Floats]) -> str:
    """Return our rule's ratios to what it has to be better than, a row per rate."""
    rows = []
    for percent in WRONG_PERCENT:
        name = f"{OURS}-{percent}"
        if name in scores:
            others = ("sarsa", f"annealed-{percent}", f"{OURS}-{RANDOM_PERCENT}")
            rows.append(
                [
                    f"{percent} %",
                    *(
                        page.interval(page.verdict(name, other, scores).ratio)
                        if other in scores and other != name
                        else ""
                        for other in others
                    ),
                ]
            )
    if not rows:
        return "These trials were not played.\n"
    return page.table(["wrong", "ratio to Sarsa", "to annealed", "to random presses"], rows)


def _people_table(results: Results, scores: Mapping[str, Floats]) -> str:
    """Return the ratio to Sarsa alone of each rule with each named participant, and w_h at the end."""
    rows = []
    for participant in PEOPLE:
        cells = []
        for rule in TRIED_ON_PEOPLE:
            name = f"{rule}-{participant}"
            if name in scores and "sarsa" in scores:
                weight = weights_used(results, name)[:, -1].mean()
                ratio = page.verdict(name, "sarsa", scores).ratio
                cells.append(f"{page.interval(ratio)} ({round(float(weight), 2) + 0.0:.2f})")
            else:
                cells.append("")
        if any(cells):
            rows.append([participant, *cells])
    if not rows:
        return "These trials were not played.\n"
    columns = [f"{RULES[rule]}: ratio to Sarsa (w_h at the end)" for rule in TRIED_ON_PEOPLE]
    return page.table(["person", *columns], rows)


RULES = {name: label for name, (label, _) in _rules(person()).items()}


def report(results: Results) -> Page:
    """Return the page of the Sarsa arm: every rule at every rate against Sarsa alone."""
    scores = {name: by_time(results, name, "seconds").mean(axis=1) for name in results.conditions}
    found: dict[str, dict[int, AtRate]] = {}
    verdicts = []
    for rule, label in RULES.items():
        for percent in WRONG_PERCENT:
            name = f"{rule}-{percent}"
            if name in scores and "sarsa" in scores:
                verdicts.append(page.verdict(name, "sarsa", scores))
                weight = float(weights_used(results, name)[:, -1].mean())
                found.setdefault(label, {})[percent] = AtRate(verdicts[-1].ratio, weight)
    drawn = {RULES[rule]: found[RULES[rule]] for rule in DRAWN if RULES[rule] in found}
    text = f"""\
# {EXPERIMENT.title}

{in_short(found, RULES[OURS], "Sarsa alone")}
A simulated person watches every episode, presses at most 2 keys in it, and errs as often as the column says; {HOURS:g} simulated hours,
{len(results.seeds)} trials, paired by seed. Ratio of scores to Sarsa without a person, with 95 % interval:

{ratios_table(found, WRONG_PERCENT)}
{summary(found)}
![Five rules at every rate](../figures/robustness-keepaway.png)

Learners side by side against Sarsa alone, the annealed combination with the same person, and themselves with random presses, whose gain is exploration:

{_goal_table(scores)}
Mean weight of the participant in the last tenth of the time:

{weights_table(found, WRONG_PERCENT)}
## Simulated people by name

People of `core.feedback.simulated_participants`, 1 press in 10 wrong unless the name says otherwise, as talkative as above (expert, noisy, useless and adversary are the rates):

{_people_table(results, scores)}
{WHY}## Scores

{SCORES_TEXT}
{page.summary_table(scores, "seconds per episode")}
## How to read this

{page.HOW_TO_READ}
{page.verdict_table(verdicts)}
{page.how_it_was_made(results)}"""  # noqa: E501
    return Page("robustness-keepaway", text, {"robustness-keepaway": rates_figure(drawn, WRONG_PERCENT)})
