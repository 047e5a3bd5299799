"""Robustness: how wrong may a participant be, and when should an agent listen? Trust rules against rates of
wrong presses.
"""

from collections.abc import Iterator

import msgspec

from core.combination.config import (
    AgentConfig,
    Annealed,
    Constant,
    EnvironmentOnly,
    Scheme,
)
from core.feedback.config import TrainerConfig
from core.feedback.simulated_participants import person
from core.session.protocol import Protocol
from studies.experiments.fig6 import gradient_condition
from studies.experiments.page import Page
from studies.experiments.results import Results
from studies.experiments.robustness_settings import (
    ENVIRONMENT,
    FRESH,
    FRESH_ENVIRONMENT,
    GRADIENT,
    MARGIN,
    PEOPLE,
    RATES,
    RULE,
    TRUST,
)
from studies.experiments.sweep import Condition, Experiment, Rows
from studies.experiments.tetris_settings import DEPARTURES, PERSON, quick, session, tetris_agent
from studies.experiments.tetris_trial import run_trial


class FreshTrial(msgspec.Struct, frozen=True):
    """A trial on other root seeds."""

    protocol: Protocol
    seeds_from: int = FRESH
    """Added to the root seed."""


def wrong(rate: int) -> TrainerConfig:
    """Return the participant of Fig. 5 with another rate of wrong presses, in per cent."""
    return msgspec.structs.replace(PERSON, mistake_rate=rate / 100)


def talkative(name: str) -> TrainerConfig:
    """Return a named participant who is as talkative as the participant of Fig. 5."""
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
    found.append(gradient_condition(GRADIENT, "policy gradient, environment only", alone))
    for rate in RATES:
        found.append(gradient_condition(f"gradient-{rate:03d}", "policy gradient", listening, wrong(rate)))
    for name in PEOPLE:
        found.append(gradient_condition(f"gradient-{name}", name, listening, talkative(name)))
    return tuple(found)


def _fresh_conditions() -> Iterator[Condition]:
    """Yield what the goal is judged by, and all participants whom the rule meets, on seeds of their own."""

    def fresh(name: str, label: str, agent: AgentConfig, participant: TrainerConfig = PERSON) -> Condition:
        return Condition(name, label, FreshTrial(session(agent, participant)))

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
        yield fresh(f"person-{name}", name, listening, talkative(name))


def run_any(settings: Protocol | FreshTrial, root_seed: int) -> Rows:
    """Play a trial on its root seed, or on the one that a fresh trial has in its place."""
    if isinstance(settings, FreshTrial):
        return run_trial(settings.protocol, settings.seeds_from + root_seed)
    return run_trial(settings, root_seed)


def quick_any(settings: Protocol | FreshTrial) -> Protocol | FreshTrial:
    """Return a trial of a second."""
    if isinstance(settings, FreshTrial):
        return FreshTrial(quick(settings.protocol), settings.seeds_from)
    return quick(settings)


EXPERIMENT = Experiment(
    name="robustness",
    title="Robustness: when should an agent listen?",
    conditions=_conditions(),
    trial=run_any,
    quick=quick_any,
    departures=DEPARTURES,
)


def report(results: Results) -> Page:
    """Return the page; it is written in `studies.experiments.robustness_page`."""
    from studies.experiments.robustness_page import robustness_page

    return robustness_page(results)
