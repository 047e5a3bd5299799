"""Values of a protocol that are each in their range and together mean what nobody wants.

`contradictions` are refused when a protocol is read; `warnings_of` are shown before a session starts.
"""

from collections.abc import Iterator

from core.combination.config import Coach
from core.configuration.messages import Path
from core.configuration.reading import Problem
from core.feedback.delays import (
    CurrentStep,
    Delay,
    GammaDelay,
    PerValueDelay,
    PreviousStep,
)
from core.learners.human_config import SgdModel
from core.plugins import plugin_of
from core.session.answer_keys import keys_used_twice
from core.session.protocol import Protocol

USUAL_MEAN_S = 10.0
"""A longer mean delay is a slip of units: people's medians are 0.6 to 2.4 s."""
RAW_STEP = 0.01
"""Largest step size of gradient descent on raw inputs (up to 20 each): above it H diverges."""


def contradictions(protocol: Protocol) -> Iterator[Problem]:
    """Yield what nobody means though each value is in its range: for protocols that are about to be run."""
    agent, session = protocol.agent, protocol.session
    delays: list[tuple[Path, Delay]] = [
        (("agent", "credit", "delay"), agent.credit.delay),
        (("trainer", "delay"), protocol.trainer.delay),
    ]
    delays += [
        (("people", number, "delay"), person.delay)
        for number, person in enumerate(protocol.people)
        if person.delay is not None
    ]
    delays += [(("others", number, "delay"), other.delay) for number, other in enumerate(protocol.others)]
    for path, delay in delays:
        reason = wrong_delay(delay)
        if reason:
            key, value = ("scale_s", delay.scale_s) if isinstance(delay, GammaDelay) else ("high_s", None)
            yield Problem((*path, key), reason, value)
    if isinstance(agent.scheme, Coach) and session.watched == "top":
        yield Problem(
            ("session", "watched"),
            'with the scheme coach set watched = "proposed": a top policy is played as it is, so presses from '  # noqa: E501
            "the second watched episode on would be recorded as credited and teach nothing",
            session.watched,
        )
    model = agent.human_model
    if isinstance(model, SgdModel) and not model.standardise and model.step_size > RAW_STEP:
        yield Problem(
            ("agent", "human_model", "step_size"),
            f"without standardising a step size above {RAW_STEP:g} makes the human model diverge to "
            "infinity; make it smaller, or set standardise = true",
            model.step_size,
        )
    yield from plugin_of(protocol).contradictions(protocol)
    yield from keys_used_twice(protocol)
    low_ms, high_ms = protocol.keys.repeat_delay_ms
    if low_ms > high_ms:
        yield Problem(
            ("keys", "repeat_delay_ms"),
            "expected the shortest delay first, then the longest",
            protocol.keys.repeat_delay_ms,
        )


def wrong_delay(delay: Delay) -> str:
    """Return why nobody means a delay; "" for one that a participant may have."""
    match delay:
        case PerValueDelay():
            return next(filter(None, map(wrong_delay, delay.densities)), "")
        case PreviousStep() | CurrentStep():
            return ""
        case _:
            mean_s = delay.mean_s
    if mean_s <= USUAL_MEAN_S:
        return ""
    return (
        f"a mean delay of {mean_s:g} seconds is one that nobody means: expected at most {USUAL_MEAN_S:g} "
        "seconds; is it in milliseconds?"
    )


def warnings_of(protocol: Protocol) -> Iterator[str]:
    """Yield what an experimenter may not have meant, in sentences, for the start of a session."""
    session = protocol.session
    never_proposes = session.watched == "top" and session.unseen_between == 0 and session.episodes > 1
    if protocol.learner.kind != "stepwise" and never_proposes:
        yield (
            'with watched = "top" and unseen_between = 0 the learner plays only '
            + ("before the first game" if session.unseen_before else "the first game")
            + ": the environment teaches nothing after it"
        )
