"""`arl protocol --check FILE`, and the same in short before a session: what a protocol will do."""

from collections.abc import Iterator, Mapping
from pathlib import Path

import click
import msgspec

from arl_tui.commands.credit import credit_lines
from core.effects import idle, warnings_of
from core.feedback.delays import GammaDelay, describe
from core.protocol import DEFAULTS, Protocol
from core.reading import printable
from core.session_plan import lines, plan

ENOUGH = 0.70
"""Below this share the pace or the credit rule should be another one (docs/decisions/pace-of-a-session.md)."""


def check_protocol(path: Path, protocol: Protocol) -> None:
    """Print what a session of a protocol file will do; compiled code is loaded for the last lines."""
    click.echo(f"{printable(str(path))}: can be used.")
    topics = plan(protocol)
    topics["Compiled"] = _compiled(protocol)  # before anything is
    topics["Reach"] = _reach(protocol)
    click.echo("\n".join(lines(topics)))
    for sentence in protocol.departures():
        click.echo(f"  Note: {sentence}.")
    for sentence in notes(protocol):
        click.echo(f"  Beware: {sentence}.")


def tell_start(protocol: Protocol, source: Mapping[str, str], recordings: Path, participant: str) -> None:
    """Print for the experimenter what is about to start: how much, whose delay gives credit, what has no effect.

    The weight of the participant is left out: the participant may see this page.
    """
    topics = plan(protocol)
    first, *more = credit_lines(source, recordings, participant, protocol.game)
    click.echo(f"Session of {participant}: protocol {printable(protocol.name)}")
    click.echo(
        "\n".join(lines({topic: topics[topic] for topic in ("Games", "Presses", "Time")} | {"Credit": first}))
    )
    for text in more:
        click.echo(f"           {text}")
    for sentence in notes(protocol):
        click.echo(f"  Beware: {sentence}.")


def notes(protocol: Protocol) -> Iterator[str]:
    """Yield what has no effect in a live session, and what an experimenter may not have meant."""
    yield from map(str, idle(protocol, DEFAULTS[protocol.game], ["live"]))
    yield from warnings_of(protocol, "live")


def _reach(protocol: Protocol) -> str:
    """Return the share of a press that reaches the step it was meant for, under the delay in force."""
    from core.feedback.reach import delay_in_force, reach_of  # here, not above: compiled code comes with it

    measured = protocol.delay_of != "rule"
    if measured:
        # Each participant has their own: the paper's stands for them here.
        credit = msgspec.structs.replace(protocol.agent.credit, delay=GammaDelay())
        agent = msgspec.structs.replace(protocol.agent, credit=credit)
        protocol = msgspec.structs.replace(protocol, agent=agent)
    reach = reach_of(protocol)
    text = (
        f"{reach.share:.0%} of a press reaches the step it was meant for, for a participant with the delay "
        f"{describe(delay_in_force(protocol))} (a step lasts {reach.step_s:.2g} s)"
    )
    return text if reach.share >= ENOUGH else f"{text}: less than {ENOUGH:.0%}; a slower pace reaches more"


def _compiled(protocol: Protocol) -> str:
    import os

    import core.compiled  # noqa: F401 - sets the cache folder

    folder = Path(os.environ["NUMBA_CACHE_DIR"])
    kept = sum(1 for _ in folder.rglob("*.nbc"))
    if kept:
        return f"the kernels of {protocol.game}; {kept} compiled parts of the program are kept in {folder}"
    return f"the kernels of {protocol.game}, at the first start: a minute or two"
