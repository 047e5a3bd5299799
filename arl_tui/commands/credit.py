"""Whose delay gives credit: `--credit`, or else the protocol's `delay_of`: one rule for every participant."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import assert_never

import click
import msgspec

from arl_tui.command_line import say
from arl_tui.participants import (
    CHOICES,
    MEASURED,
    CreditChoice,
    ParticipantError,
    choose_credit,
    group_credit,
    home_of,
    read_delays,
    rule_as_written,
    task_key,
    task_of,
)
from core.feedback.delays import Delay, PerValueDelay
from core.feedback.people import PersonConfig
from core.recording.reader import Recording
from core.session.contradictions import wrong_delay
from core.session.protocol import Protocol


def credit_of(text: str, recordings: Path, participant: str, game: str) -> CreditChoice:
    """Return the rule that `text` names, after saying why it may not be trusted; stop where there is none."""
    try:
        choice = choose_credit(text, recordings, participant, game)
    except ParticipantError as error:
        raise click.ClickException(str(error)) from error
    except ValueError as error:
        raise click.BadParameter(f"{error}; or one of {', '.join(CHOICES)}", param_hint="--credit") from error
    reason = wrong_delay(choice.delay)
    if reason:
        raise click.BadParameter(reason, param_hint="--credit")
    for warning in choice.warnings:
        say(f"Credit of {participant}: beware: {warning}", err=True)
    return choice


def settle_credit(
    protocol: Protocol, option: str | None, recordings: Path, participant: str
) -> tuple[Protocol, dict[str, str]]:
    """Return the protocol with its credit rule in numbers, and where that comes from, for the recording's
    header.

    The rule is the same for every participant, with or without a protocol file
    (`docs/decisions/one-rule-of-credit.md`).

    Args:
        protocol: its `delay_of` counts where the command line says nothing.
        option: `--credit`; None where it was not given.
        recordings: folder beside which participants' delays are kept.
        participant: pseudonym.
    """
    asked = option if option is not None else protocol.delay_of
    if protocol.people and asked != "rule":
        return _settle_people(protocol, asked, option, recordings)
    by = {"credit_asked_by": "protocol" if option is None else "command line"}
    if asked == "rule":
        choice = rule_as_written(protocol.agent.credit.delay)
    else:
        choice = _choice_of(protocol, asked, recordings, participant)
    return with_credit(protocol, choice), choice.source | by


def _settle_people(
    protocol: Protocol, asked: str, option: str | None, recordings: Path
) -> tuple[Protocol, dict[str, str]]:
    """Return the protocol with the delay of each participant at the keyboard in numbers, found under their
    code, and where each comes from.
    """
    people: list[PersonConfig] = []
    sources: dict[str, str] = {}
    for person in protocol.people:
        choice = _choice_of(protocol, asked, recordings, person.name)
        people.append(msgspec.structs.replace(person, delay=choice.delay))
        sources |= {f"{name} of {person.name}": value for name, value in choice.source.items()}
    rules = "; ".join(f"{person.name} {sources[f'credit_rule of {person.name}']}" for person in people)
    shared = {
        "credit": asked,
        "credit_rule": rules,
        "credit_asked_by": "protocol" if option is None else "command line",
    }
    return msgspec.structs.replace(protocol, people=tuple(people), delay_of="rule"), shared | sources


def _choice_of(protocol: Protocol, asked: str, recordings: Path, participant: str) -> CreditChoice:
    """Return the rule that `asked` names for a participant, or what the protocol says where they have
    none.
    """
    if asked in MEASURED and not is_measured(asked, recordings, participant, protocol.game):
        return _without_measurement(protocol, asked, recordings, participant)
    return credit_of(asked, recordings, participant, protocol.game)


def _without_measurement(protocol: Protocol, asked: str, recordings: Path, participant: str) -> CreditChoice:
    """Return the rule of a participant without a measured delay, as `delay_if_missing` says."""
    missing = {"credit_missing": f"{participant} has no measured delay: {protocol.delay_if_missing}"}
    match protocol.delay_if_missing:
        case "refuse":
            return credit_of(asked, recordings, participant, protocol.game)  # says what to do, and stops
        case "paper":
            choice = choose_credit("paper", recordings, participant, protocol.game)
        case "pooled":
            try:
                choice = group_credit(recordings, protocol.game)
            except ParticipantError as error:
                raise click.ClickException(str(error)) from error
        case _:
            assert_never(protocol.delay_if_missing)
    return msgspec.structs.replace(choice, source={**choice.source, "credit_asked": asked, **missing})


def is_measured(asked: str, recordings: Path, participant: str, game: str) -> bool:
    """Return whether a participant has the delay that `asked` names; stop where its file is damaged."""
    try:
        known = read_delays(recordings, participant)
    except ParticipantError as error:
        raise click.ClickException(str(error)) from error
    fit = None if known is None else known.tasks.get(task_key(task_of(asked), game))
    return fit is not None and (asked != "pooled" or fit.pooled is not None)


def credit_lines(source: Mapping[str, str], recordings: Path, participant: str, game: str) -> Iterator[str]:
    """Yield in words which rule gives credit, whose it is, and from which trials: for the experimenter."""
    who = f"asked for by the {source['credit_asked_by']}"
    yield f"{source['credit_rule']} ({source['credit']}, {who})"
    if "credit_missing" in source:
        yield source["credit_missing"]
    if "credit_files" in source:
        fitted = f"fitted {source['credit_fitted_utc']} from {source['credit_files']}"
        yield f"task {source['credit_task']}, {fitted}"
    elif source["credit"] != "paper" and is_measured("feedback-lag", recordings, participant, game):
        yield (
            f"{participant} has a measured delay of judging, which is not used: "
            'delay_of = "feedback-lag" in the protocol uses everybody\'s own'
        )


def with_credit(protocol: Protocol, choice: CreditChoice) -> Protocol:
    """Return the protocol with another credit rule, which needs nobody's measurements any more."""
    credit = msgspec.structs.replace(protocol.agent.credit, delay=choice.delay)
    agent = msgspec.structs.replace(protocol.agent, credit=credit)
    return msgspec.structs.replace(protocol, agent=agent, delay_of="rule")


def credited_alike(protocol: Protocol) -> Protocol:
    """Return the protocol with one credit rule for all participants at the keyboard: `agent.credit.delay`."""
    people = tuple(msgspec.structs.replace(person, delay=None) for person in protocol.people)
    return msgspec.structs.replace(protocol, people=people)


def what_if_delays(texts: Sequence[str], recording: Recording, protocol: Protocol) -> dict[Delay, str]:
    """Return the credit rules of a what-if, each with where it comes from in words; print those of
    participants.

    Args:
        texts: from the command line; "rule" is the protocol's.
        recording: whose participant's delays are meant.
        protocol: of the what-if.
    """
    found: dict[Delay, str] = {}
    for text in texts:
        own = protocol.agent.credit.delay
        if text == "rule" or (text == "per-value" and isinstance(own, PerValueDelay)):
            choice = rule_as_written(own)
        elif text in MEASURED and protocol.people:
            names = ", ".join(person.name for person in protocol.people)
            raise click.ClickException(
                f"--credit {text}: a what-if credits everybody by one rule, and {names} have delays of their "
                "own: name a rule, or only --scheme"
            )
        else:
            choice = _choice_of(protocol, text, home_of(recording.path), recording.header.participant)
        words = "; ".join(f"{name.removeprefix('credit_')} {value}" for name, value in choice.source.items())
        if text in CHOICES:
            say(f"Credit: {words}")
        found[choice.delay] = words
    return found
