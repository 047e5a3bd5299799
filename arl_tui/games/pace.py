"""What is said about a session's pace: in its header, and to the experimenter where presses often miss."""

from arl_tui.app.link import Ready
from arl_tui.games.registry import screens_of
from core.feedback.delays import CurrentStep, GammaDelay, PreviousStep, describe
from core.session.protocol import ENOUGH_REACH, Protocol


def pace_facts(ready: Ready | None) -> dict[str, str]:
    """Return what a header says: the share of a press that reaches its step, and the time on screen."""
    if ready is None or ready.reach is None:
        return {}
    return {
        "share of a press that reaches its step": f"{ready.reach:.3f}",
        "seconds per step": f"{ready.step_s:.3f}",
    }


def pace_line(protocol: Protocol, ready: Ready | None) -> str:
    """Return one line for the experimenter: the share of a press that reaches its step; empty if unknown.

    Args:
        protocol: of the session.
        ready: what the worker has worked out; None where it has not yet.
    """
    if ready is None or ready.reach is None:
        return ""
    return f"about {ready.reach:.0%} of a press reaches its {screens_of(protocol).words.step}"


def pace_warning(protocol: Protocol, ready: Ready | None) -> str:
    """Return a sentence for the experimenter, or nothing where at least 70 % of a press reach their step.

    Args:
        protocol: of the session.
        ready: what the worker has worked out; None where it has not yet.
    """
    if ready is None or ready.reach is None or ready.reach >= ENOUGH_REACH:
        return ""
    rule = protocol.agent.credit.delay
    delay = GammaDelay() if isinstance(rule, PreviousStep | CurrentStep) else rule
    screens = screens_of(protocol)
    return (
        f"at this pace about {ready.reach:.0%} of a press reaches the {screens.words.step} it is meant "
        f"for ({ready.step_s:.2f} s each, delay {describe(delay)} s, rule {describe(rule)}). "
        f"{screens.slower(protocol.screen)}."
    )
