"""`--credit`: a rule by name, or a participant's own delay."""

from pathlib import Path

import click
import msgspec

from arl_tui.participants import CHOICES, CreditChoice, ParticipantError, choose_credit, home_of
from core.feedback.credit import describe
from core.protocol import Protocol
from core.recording.reader import Recording


def credit_of(text: str, recordings: Path, participant: str) -> CreditChoice:
    """Return the rule that `text` names, after saying why it may not be trusted; stop where there is none."""
    try:
        choice = choose_credit(text, recordings, participant)
    except ParticipantError as error:
        raise click.ClickException(str(error)) from error
    except ValueError as error:
        raise click.BadParameter(f"{error}; or one of {', '.join(CHOICES)}", param_hint="--credit") from error
    for warning in choice.warnings:
        click.echo(f"Credit of {participant}: beware: {warning}", err=True)
    return choice


def with_credit(protocol: Protocol, choice: CreditChoice) -> Protocol:
    """Return the protocol with another credit rule."""
    credit = msgspec.structs.replace(protocol.agent.credit, delay=choice.delay)
    agent = msgspec.structs.replace(protocol.agent, credit=credit)
    return msgspec.structs.replace(protocol, agent=agent)


def rule_in_numbers(text: str, recording: Recording) -> str:
    """Return a what-if's rule with a participant's delay put in as numbers; other rules as they are."""
    if text not in CHOICES:
        return text
    participant = recording.header.participant
    choice = credit_of(text, home_of(recording.path), participant)
    click.echo(f"{text}: {describe(choice.delay)} ({participant})", err=True)
    return describe(choice.delay)
