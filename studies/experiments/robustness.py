"""Robustness: how wrong may a person be, and when should an agent listen? Trust rules against rates of wrong presses."""

from collections.abc import Iterator, Mapping

import msgspec

from core.combination.config import (
    AgentConfig,
    Annealed,
    Constant,
    EnvironmentOnly,
    Equation4,
    Equation5,
    RankCorrelation,
    Scheme,
    Signed,
    Tried,
    TrustRule,
)
from core.feedback.config import TrainerConfig
from core.feedback.simulated_participants import person
from core.session.protocol import Protocol
from studies.experiments.fig6 import gradient_trial, quick_gradient
from studies.experiments.page import Page
from studies.experiments.results import Results
from studies.experiments.sweep import Condition, Experiment, Rows
from studies.experiments.tetris_settings import DEPARTURES, PERSON, quick, session, tetris_agent
from studies.experiments.tetris_trial import GradientTrial, run_gradient_trial, run_trial

RATES = (0, 10, 30, 50, 80, 100)
"""Wrong presses, per cent."""
RULE = Signed(margin=0.1)
"""The rule under test. Its constants were found on root seeds from 900000 on, and written down before any trial that the goal is
judged by was played (`docs/decisions/margin-of-agreement.md`)."""

FRESH = 1000
"""What is added to the root seeds of the trials that the goal is judged by. Their first twenty, 0 to 19, had been looked at
under other rules when this one was fixed."""

TRUST: dict[str, tuple[str, TrustRule]] = {
    "tried": ("trust by trial", Tried()),
    "signed": ("signed agreement", Signed()),
    "eq4": ("Eq. 4", Equation4()),
    "eq5": ("Eq. 5", Equation5()),
    "chance": ("chance-corrected", Equation4(match="chance-corrected", chance=0.15)),
    "rank": ("rank correlation", RankCorrelation()),
    "rank-signed": ("signed rank correlation", RankCorrelation(signed=True)),
}
"""Rules of trust by name: (label, rule). 0.15 is the agreement of unrelated policies (`docs/decisions/degree-of-match.md`)."""
MARGIN = "margin"
"""Name of the rule under test in conditions."""

PEOPLE = ("lay", "myopic", "hesitant", "instructed", "bursty", "hasty", "slow", "tiring", "leaves")
"""Simulated people by name (`core.feedback.simulated_participants`) whom the rule meets beside the rates, which are the other four."""

ENVIRONMENT = "environment"
FRESH_ENVIRONMENT = "fresh-environment"
GRADIENT = "gradient"


class FreshTrial(msgspec.Struct, frozen=True):
    """A trial on other root seeds."""

    protocol: Protocol
    seeds_from: int = FRESH
    """Added to the root seed."""


def wrong(rate: int) -> TrainerConfig:
    """Return the person of Fig. 5 with another rate of wrong presses, in per cent."""
    return msgspec.structs.replace(PERSON, mistake_rate=rate / 100)


def somebody(name: str) -> TrainerConfig:
    """Return a named person who is as talkative as the person of Fig. 5."""
    return msgspec.structs.replace(person(name), press_probability=PERSON.press_probability)


def _conditions() -> tuple[Condition, ...]:
    alone = tetris_agent(scheme=EnvironmentOnly())
    found = [Condition(ENVIRONMENT, "environment only", session(alone))]
    for rate in RATES:
        fixed: dict[str, Scheme] = {"annealed": Annealed(per="episode"), "constant": Constant()}
        for name, scheme in fixed.items():
            agent = tetris_agent(scheme=scheme)
            found.append(Condition(f"{name}-{rate:03d}", name, session(agent, wrong(rate))))
        for name, (label, trust) in TRUST.items():
            agent = tetris_agent(trust=trust)
            found.append(Condition(f"{name}-{rate:03d}", label, session(agent, wrong(rate))))
    found.extend(_fresh_conditions())
    listening = tetris_agent(trust=RULE)
    found.append(Condition(GRADIENT, "policy gradient, environment only", gradient_trial(alone)))
    for rate in RATES:
        found.append(
            Condition(f"gradient-{rate:03d}", "policy gradient", gradient_trial(listening, wrong(rate)))
        )
    for name in PEOPLE:
        found.append(Condition(f"gradient-{name}", name, gradient_trial(listening, somebody(name))))
    return tuple(found)


def _fresh_conditions() -> Iterator[Condition]:
    """Yield what the goal is judged by, and everybody whom the rule meets, on seeds of their own."""

    def fresh(name: str, label: str, agent: AgentConfig, someone: TrainerConfig = PERSON) -> Condition:
        return Condition(name, label, FreshTrial(session(agent, someone)))

    listening = tetris_agent(trust=RULE)
    yield fresh(FRESH_ENVIRONMENT, "environment only", tetris_agent(scheme=EnvironmentOnly()))
    for rate in (10, 30):
        yield fresh(
            f"fresh-annealed-{rate:03d}",
            "annealed",
            tetris_agent(scheme=Annealed(per="episode")),
            wrong(rate),
        )
    for rate in RATES:
        yield fresh(f"{MARGIN}-{rate:03d}", "signed agreement with a margin (ours)", listening, wrong(rate))
    for name in PEOPLE:
        yield fresh(f"person-{name}", name, listening, somebody(name))


def run_any(settings: Protocol | FreshTrial | GradientTrial, root_seed: int) -> Rows:
    """Play a trial of either learner."""
    if isinstance(settings, FreshTrial):
        return run_trial(settings.protocol, settings.seeds_from + root_seed)
    if isinstance(settings, GradientTrial):
        return run_gradient_trial(settings, root_seed)
    return run_trial(settings, root_seed)


def quick_any(settings: Protocol | FreshTrial | GradientTrial) -> Protocol | FreshTrial | GradientTrial:
    """Return a trial of a second."""
    if isinstance(settings, FreshTrial):
        return FreshTrial(quick(settings.protocol), settings.seeds_from)
    return quick_gradient(settings) if isinstance(settings, GradientTrial) else quick(settings)


EXPERIMENT = Experiment(
    name="robustness",
    title="Robustness: when should an agent listen?",
    conditions=_conditions(),
    trial=run_any,
    quick=quick_any,
    departures=DEPARTURES,
)


def by_rate(rule: str, names: Mapping[str, object]) -> dict[int, str]:
    """Return the conditions of a rule that are among `names`, by rate in per cent."""
    found = {rate: f"{rule}-{rate:03d}" for rate in RATES}
    return {rate: name for rate, name in found.items() if name in names}


def report(results: Results) -> Page:
    """Return the page; it is written in `studies.experiments.robustness_page`."""
    from studies.experiments.robustness_page import robustness_page

    return robustness_page(results)
