"""Whose delay gives credit: `--credit`, or else the protocol's `delay_of`, or without either whoever has one."""

from collections.abc import Sequence
from pathlib import Path

import click
import msgspec

from arl_tui.participants import (
    CHOICES,
    FEEDBACK_LAG,
    CreditChoice,
    ParticipantError,
    choose_credit,
    home_of,
    read_delays,
    rule_as_written,
    task_key,
)
from core.feedback.delays import Delay
from core.protocol import Protocol
from core.recording.reader import Recording


def credit_of(text: str, recordings: Path, participant: str, game: str) -> CreditChoice:
    """Return the rule that `text` names, after saying why it may not be trusted; stop where there is none."""
    try:
        choice = choose_credit(text, recordings, participant, game)
    except ParticipantError as error:
        raise click.ClickException(str(error)) from error
    except ValueError as error:
        raise click.BadParameter(f"{error}; or one of {', '.join(CHOICES)}", param_hint="--credit") from error
    for warning in choice.warnings:
        click.echo(f"Credit of {participant}: beware: {warning}", err=True)
    return choice


def settle_credit(
    protocol: Protocol,
    option: str | None,
    recordings: Path,
    participant: str,
    *,
    own_if_measured: bool = False,
) -> tuple[Protocol, dict[str, str]]:
    """Return the protocol with its credit rule in numbers, and where that comes from, for the recording's header.

    Args:
        protocol: its `delay_of` counts where the command line says nothing.
        option: `--credit`; None where it was not given.
        recordings: folder beside which participants' delays are kept.
        participant: pseudonym.
        own_if_measured: nobody has chosen the protocol: without `option` the participant's own delay of judging this
            game counts, where it has been measured.
    """
    asked = option if option is not None else protocol.delay_of
    by = "protocol" if option is None else "command line"
    if option is None and own_if_measured:
        by = "default"
        if has_fit(recordings, participant, protocol.game):
            asked = "participant"
    if asked == "rule":
        choice = rule_as_written(protocol.agent.credit.delay)
    else:
        choice = credit_of(asked, recordings, participant, protocol.game)
    return with_credit(protocol, choice), choice.source | {"credit_asked_by": by}


def has_fit(recordings: Path, participant: str, game: str) -> bool:
    """Return whether the participant's delay of judging a game has been measured; stop where the file is damaged."""
    try:
        known = read_delays(recordings, participant)
    except ParticipantError as error:
        raise click.ClickException(str(error)) from error
    return known is not None and task_key(FEEDBACK_LAG, game) in known.tasks


def with_credit(protocol: Protocol, choice: CreditChoice) -> Protocol:
    """Return the protocol with another credit rule, which needs nobody's measurements any more."""
    credit = msgspec.structs.replace(protocol.agent.credit, delay=choice.delay)
    agent = msgspec.structs.replace(protocol.agent, credit=credit)
    return msgspec.structs.replace(protocol, agent=agent, delay_of="rule")


def what_if_delays(texts: Sequence[str], recording: Recording, protocol: Protocol) -> dict[Delay, str]:
    """Return the credit rules of a what-if, each with where it comes from in words; print those of participants.

    Args:
        texts: from the command line; "rule" is the protocol's.
        recording: whose participant's delays are meant.
        protocol: of the what-if.
    """
    found: dict[Delay, str] = {}
    for text in texts:
        if text == "rule":
            choice = rule_as_written(protocol.agent.credit.delay)
        else:
            choice = credit_of(text, home_of(recording.path), recording.header.participant, protocol.game)
        words = "; ".join(f"{name.removeprefix('credit_')} {value}" for name, value in choice.source.items())
        if text in CHOICES:
            click.echo(f"Credit: {words}")
        found[choice.delay] = words
    return found
