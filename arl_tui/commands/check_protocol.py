"""`arl protocol --check FILE`, and the same in short before a session: what a protocol will do."""

import shutil
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import click
import msgspec

from arl_tui.command_line import say
from arl_tui.commands.credit import credit_lines
from arl_tui.games.registry import try_out
from core.configuration.messages import printable
from core.feedback.delays import GammaDelay, describe
from core.plugins import GameError, plugin_of
from core.session.contradictions import warnings_of
from core.session.effects import idle
from core.session.plan import plan
from core.session.protocol import DEFAULTS, ENOUGH_REACH, Protocol

WIDEST = 110
"""Columns of a line at most."""
INDENT = 10
"""Columns of the topics."""

IN_SHORT = ("Games", "Presses", "Time", "Weight", "Credit", "Compiled", "Reach")
"""The topics that are printed before a session, in order."""
WEIGHT_NOT_SHOWN = (
    "F2 on the first page says it, before the participant looks; so does `arl protocol --check FILE`"
)


def check_protocol(path: Path, protocol: Protocol) -> None:
    """Print what a session of a protocol file will do; compiled code is loaded for the last lines.

    Rules that are not the program's own are tried: stop with a message where they cannot be played.
    """
    if plugin_of(protocol).foreign:
        try:
            try_out(protocol)
        except GameError as error:
            raise click.ClickException(f"{printable(str(path))}: {error}") from error
    say(f"{printable(str(path))}: can be used.")
    tell_protocol(protocol)


def tell_protocol(protocol: Protocol) -> None:
    """Print what sessions of a protocol do, topic by topic."""
    topics = plan(protocol)
    topics["Compiled"] = _compiled(protocol)  # before anything is
    topics["Reach"] = _reach(protocol)
    _tell([*topics.items(), *(("Note", f"{sentence}.") for sentence in protocol.departures())])
    _tell([("Beware", f"{sentence}.") for sentence in notes(protocol)])


def tell_start(protocol: Protocol, source: Mapping[str, str], recordings: Path, participant: str) -> None:
    """Print what is about to start: how much, whose delay gives credit, what is compiled, what has no effect.

    The protocol's name is not in it, and the weight only where the participant may see it: the participant
    may look at this page. The reach takes seconds to work out: the first screen says it when it is known.
    """
    topics = plan(protocol)
    say(f"Session of {participant}:")
    topics["Credit"] = "; ".join(credit_lines(source, recordings, participant, protocol.game))
    if not protocol.screen.show_weight:
        topics["Weight"] = WEIGHT_NOT_SHOWN
    topics["Compiled"] = _compiled(protocol)
    topics["Reach"] = "said on the first screen as soon as it is worked out"
    _tell([(topic, topics[topic]) for topic in IN_SHORT])
    _tell([("Beware", f"{sentence}.") for sentence in notes(protocol)])


def _tell(topics: Sequence[tuple[str, str]]) -> None:
    """Print topics in two columns, as wide as the terminal."""
    width = max(40, min(shutil.get_terminal_size().columns, WIDEST))
    for topic, text in topics:
        indent = " " * (INDENT + 2)
        say(
            textwrap.fill(
                f"  {topic:{INDENT - 2}}  {text}", width, subsequent_indent=indent, break_on_hyphens=False
            )
        )


def notes(protocol: Protocol) -> Iterator[str]:
    """Yield what has no effect in a live session, and what an experimenter may not have meant."""
    yield from map(str, idle(protocol, DEFAULTS[protocol.game], ["live"]))
    yield from warnings_of(protocol)


def _reach(protocol: Protocol) -> str:
    """Return the fraction of a press that reaches the step it was meant for, under the delay in force."""
    from core.session.reach import delay_in_force, reach_of  # here, not above: compiled code comes with it

    measured = protocol.delay_of != "rule"
    if measured:
        # Each participant has their own: the paper's stands for them here.
        credit = msgspec.structs.replace(protocol.agent.credit, delay=GammaDelay())
        agent = msgspec.structs.replace(protocol.agent, credit=credit)
        protocol = msgspec.structs.replace(protocol, agent=agent)
    reach = reach_of(protocol)
    text = (
        f"{reach.fraction:.0%} of a press reaches the step it was meant for, for a participant with the "
        f"delay {describe(delay_in_force(protocol))} (a step lasts {reach.step_s:.2g} s)"
    )
    if reach.fraction >= ENOUGH_REACH:
        return text
    return f"{text}: less than {ENOUGH_REACH:.0%}; a slower pace reaches more"


def _compiled(protocol: Protocol) -> str:
    from arl_tui.app.compile_order import is_compiled, session_order

    if is_compiled(session_order(protocol)):
        return f"the kernels of {protocol.game}, already"
    return f"the kernels of {protocol.game}, beside the first game: about half a minute"
