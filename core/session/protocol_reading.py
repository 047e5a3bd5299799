"""A protocol from plain types or from a TOML file, checked against what has an effect in its sessions."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from core.configuration.catalogue import TAG
from core.configuration.reading import ConfigurationError, Problem, read
from core.plugins import GameError
from core.recording.schema import FIRST_GAME
from core.session.contradictions import contradictions
from core.session.effects import idle
from core.session.protocol import DEFAULTS, Protocol
from core.session.protocol_file import ProtocolError, located, read_toml


def protocol_from(plain: Mapping[str, Any], *, game: str = FIRST_GAME, to_run: bool = False) -> Protocol:
    """Return the protocol that plain types describe: a recording's header, or a TOML file.

    What is not said has the default of the game. A table with another `type` than the default's stands for
    itself.

    Args:
        plain: tables as in `arl protocol`; recordings made before there was a second game do not name theirs.
        game: which one is meant where `plain` does not say.
        to_run: the protocol is about to be run, not replayed: values that nobody means, and settings that
            have no effect in any session of this protocol, are refused, too (`core.session.effects`).

    Raises:
        ConfigurationError: a key is unknown, or a value is of the wrong kind or out of range, each with
            its place.
    """
    domain = plain.get("domain", {})
    named = domain.get("type", game) if isinstance(domain, Mapping) else domain
    try:
        default = DEFAULTS.get(str(named)) or DEFAULTS[game]
    except GameError as error:
        raise ConfigurationError([Problem(("domain", TAG), str(error), named)]) from error
    protocol = read(plain, default, to_run=to_run)
    if to_run:
        problems = [*_said_twice(plain, protocol), *contradictions(protocol)]
        problems += [each.problem() for each in idle(protocol, default) if each.use.refused]
        if problems:
            raise ConfigurationError(problems)
    return protocol


def _said_twice(plain: Mapping[str, Any], protocol: Protocol) -> Iterator[Problem]:
    """Yield the settings of `[domain]` that have moved to `[learner.encoder]` (`OLD` of the domain's
    configuration) where both places are written and do not agree.
    """
    domain, learner = plain.get("domain"), plain.get("learner")
    encoder = learner.get("encoder") if isinstance(learner, Mapping) else None
    if not (isinstance(domain, Mapping) and isinstance(encoder, Mapping)):
        return
    moved: frozenset[str] = getattr(protocol.domain, "OLD", frozenset())
    for key in sorted(moved & domain.keys() & encoder.keys()):
        if domain[key] != encoder[key]:
            yield Problem(
                ("domain", key),
                f"it is the old place of [learner.encoder] {key}, which says {encoder[key]!r}: say it in "
                "[learner.encoder] alone",
                domain[key],
            )


def load_protocol(path: Path | None, *, game: str = FIRST_GAME) -> Protocol:
    """Return the protocol in a TOML file; the defaults for None.

    Args:
        path: the file: UTF-8, with or without a byte-order mark, with any line ends.
        game: which game's defaults are meant where the file does not name one.

    Raises:
        ProtocolError: the file is not TOML, or something in it cannot be used; with file, line, key and
            reason.
        OSError: the file cannot be read.
    """
    if path is None:
        return DEFAULTS[game]
    text, plain = read_toml(path)
    try:
        return protocol_from(plain, game=game, to_run=True)
    except ConfigurationError as error:
        raise ProtocolError(located(path, text, error.problems)) from error
