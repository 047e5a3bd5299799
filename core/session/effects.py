"""In which sessions a setting has an effect: the one place where this is known.

`uses` yields every setting that has an effect in some sessions only; all others have one wherever their table
is used. What is particular to a game is said by its plugin (`core.plugins`). A setting without effect is
refused when a protocol is read, or named before a session starts (`Use.refused`).
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import msgspec

from core.combination.config import (
    Coach,
    EnvironmentOnly,
    Equation4,
    Exponential,
    HumanOnly,
    Linear,
)
from core.configuration.catalogue import settings_of
from core.configuration.messages import Path, shown_path
from core.configuration.reading import Problem
from core.learners.policy_gradient_config import PolicyGradientConfig
from core.learners.sarsa_config import SarsaConfig
from core.plugins import GamePlugin, plugin_of, plugins
from core.session.protocol import Protocol

Mode = Literal["live", "simulated", "what-if"]
"""With a participant (`arl play`), simulated, or learned again from a recording (`arl replay`)."""
MODES: tuple[Mode, ...] = ("live", "simulated", "what-if")


@dataclass(frozen=True, slots=True)
class Use:
    """Where some settings have an effect."""

    settings: tuple[str, ...]
    """Dotted paths; a table stands for all that is in it."""
    where: str
    """In which sessions, in words, after "has an effect"."""
    when: Callable[[Protocol, Mode], bool]
    refused: bool = True
    """Without effect in all modes it is refused when a protocol is read; else named before the start."""


def _live(protocol: Protocol, mode: Mode) -> bool:
    return mode == "live"


def _simulated(protocol: Protocol, mode: Mode) -> bool:
    return mode == "simulated"


def _on_screen(protocol: Protocol, mode: Mode) -> bool:
    return mode != "what-if"


def _draws_top_policies(protocol: Protocol) -> bool:
    """Return whether what is watched is drawn from the top policies."""
    return protocol.session.watched == "top" and not isinstance(protocol.learner, SarsaConfig)


def _trust_is_used(protocol: Protocol) -> bool:
    """Return whether w_h of bootstrap learning decides anything: a choice, or which policy is watched."""
    by_trust = isinstance(protocol.agent.scheme, Linear | Exponential)
    return by_trust or (protocol.agent.bootstrap.symmetric and _draws_top_policies(protocol))


def _looks_back(protocol: Protocol) -> bool:
    return protocol.agent.bootstrap.trust.needs.window


def learner_counts(protocol: Protocol) -> bool:
    """Return whether the environment's learner has any say."""
    return not isinstance(protocol.agent.scheme, HumanOnly)


def _chance_counts(protocol: Protocol) -> bool:
    trust = protocol.agent.bootstrap.trust
    return isinstance(trust, Equation4) and trust.match == "chance-corrected"


def _with_traces(protocol: Protocol) -> bool:
    return isinstance(protocol.learner, SarsaConfig) and protocol.learner.trace_decay > 0


def _natural(protocol: Protocol) -> bool:
    return isinstance(protocol.learner, PolicyGradientConfig) and protocol.learner.natural


def _environment_teaches(protocol: Protocol) -> bool:
    return not isinstance(protocol.agent.scheme, Coach) or protocol.agent.scheme.environment_too


def _plays_unseen(protocol: Protocol) -> bool:
    session = protocol.session
    return session.unseen_before > 0 or (session.unseen_between > 0 and session.episodes > 1)


FORMER_DEFAULTS: dict[str, object] = {"screen.tick_ms": 80}
"""Defaults of version 0.1: its `arl protocol` wrote every setting, so files of that time hold them."""

_IN_ANY_GAME: tuple[Use, ...] = (
    Use(
        ("screen.pause_between_episodes_s",),
        "where a session is shown or simulated",
        _on_screen,
        refused=False,
    ),
    Use(
        (
            "screen.palette",
            "screen.theme",
            "screen.reduced_motion",
            "screen.count_down_s",
            "screen.mark_presses",
            "screen.show_weight",
            "screen.games_per_stretch",
            "screen.games_per_block",
        ),
        "on a screen: in live sessions only",
        _live,
        refused=False,
    ),
    Use(
        ("keys.wrong_press_rate",),
        "in live sessions only (a simulated participant has trainer.deliberate_rate)",
        _live,
        refused=False,
    ),
    Use(
        ("keys",),
        "where keys are pressed: in live and simulated sessions",
        _on_screen,
        refused=False,
    ),
    Use(("trainer",), "in simulated sessions only: in a live one the participant presses", _simulated, False),
    Use(
        ("others",), "in simulated sessions only: in a live one those press who are there", _simulated, False
    ),
    Use(
        ("keys.good", "keys.bad"),
        "with two keys for one participant: without people, and without keys.graded",
        lambda p, m: not p.people and not p.keys.graded,
    ),
    Use(
        ("keys.retract", "keys.graded"),
        "for one participant: each of several people has keys of their own",
        lambda p, m: not p.people,
    ),
    Use(
        ("trainer.burst_presses", "trainer.burst_interval_s"),
        "where trainer.burst_rate is > 0",
        lambda p, m: p.trainer.burst_rate > 0,
    ),
    Use(
        ("agent.asking",),
        "where agent.asking.per_episode is > 0",
        lambda p, m: p.agent.asking.per_episode > 0,
    ),
    Use(
        ("agent.asking",),
        "in live and simulated sessions, with every scheme but coach: a what-if learns from the questions "
        "that were recorded, and with coach answers teach a human model that has no say",
        lambda p, m: _on_screen(p, m) and not isinstance(p.agent.scheme, Coach),
        refused=False,
    ),
    Use(
        ("delay_of", "delay_if_missing"),
        "in live sessions and what-ifs: a simulated participant's delay is not measured",
        lambda p, m: m != "simulated",
        refused=False,
    ),
    Use(
        ("delay_if_missing",),
        "where delay_of names a measured delay: feedback-lag, simple or pooled",
        lambda p, m: p.delay_of in ("feedback-lag", "simple", "pooled"),
    ),
    Use(
        ("agent.credit.delay",),
        'with delay_of = "rule" only',
        lambda p, m: p.delay_of == "rule",
        refused=False,
    ),
    Use(
        ("agent.credit", "agent.human_model"),
        "on what is done with every scheme but environment-only; there presses are learned from and have no "
        "say",
        lambda p, m: not isinstance(p.agent.scheme, EnvironmentOnly),
        refused=False,
    ),
    Use(
        ("agent.human_model",),
        "on what is done with every scheme but coach: there presses teach the learner itself",
        lambda p, m: not isinstance(p.agent.scheme, Coach),
        refused=False,
    ),
    Use(
        ("agent.bootstrap.trust",),
        'on what is done with the schemes linear and exponential, and where session.watched = "top" draws '
        "policies by their match; elsewhere w_h is worked out and recorded, and nothing goes by it",
        lambda p, m: _trust_is_used(p),
        refused=False,
    ),
    Use(
        ("agent.bootstrap.trust.chance",),
        'with match = "chance-corrected" only',
        lambda p, m: _chance_counts(p),
    ),
    Use(
        ("agent.bootstrap.symmetric",),
        'with session.watched = "top" and a learner other than Sarsa: elsewhere no policy is drawn',
        lambda p, m: _draws_top_policies(p),
    ),
    Use(
        ("agent.bootstrap.window_decisions",),
        'with others or people, or a trust that looks back (measured = "window"; a chance-corrected match without chance)',  # noqa: E501
        lambda p, m: _looks_back(p) or p.n_participants > 1,
    ),
    Use(
        ("session.unseen_steps",),
        "where there are unseen episodes",
        lambda p, m: _plays_unseen(p),
        refused=False,
    ),
    Use(
        ("session.unseen_between",),
        "with two watched episodes or more",
        lambda p, m: p.session.episodes > 1,
        refused=False,
    ),
    Use(("session.watched_steps",), "where a session is shown or simulated", _on_screen, refused=False),
    Use(
        ("learner.replacing_traces", "learner.least_trace"),
        "with trace_decay > 0 only",
        lambda p, m: _with_traces(p),
    ),
    Use(
        ("learner.fisher_rate", "learner.fisher_ridge"), "with natural = true only", lambda p, m: _natural(p)
    ),
    Use(
        ("learner",),
        "on what is done with every scheme but human-only, where the environment has no say",
        lambda p, m: learner_counts(p),
        refused=False,
    ),
    Use(
        (
            "learner.step_size",
            "learner.trace_decay",
            "learner.baseline_rate",
            "learner.update",
            "learner.natural",
        ),
        "with every scheme but coach with environment_too = false",
        lambda p, m: _environment_teaches(p),
    ),
)


def uses() -> Iterator[Use]:
    """Yield every entry: those that go by the game, those of any game, those of each game's own table."""
    games = tuple(plugins())
    for path in dict.fromkeys(path for game in games for path in game.idle):
        yield _by_game(path, games)
    yield from _IN_ANY_GAME
    for game in games:
        own: tuple[Use, ...] = game.uses
        yield from own


def _by_game(path: str, games: Sequence[GamePlugin]) -> Use:
    """Return the entry of a setting that has no effect in some games."""
    having = [game.title for game in games if path not in game.idle]
    where = f"in {_all_of(having)} only" if having else "in no game"
    reasons = [reason for game in games if (reason := game.idle.get(path))]
    on_screen = path.startswith("screen.")
    return Use(
        (path,),
        ": ".join([where, "; ".join(reasons)]) if reasons else where,
        lambda p, m: path not in plugin_of(p).idle and (_on_screen(p, m) or not on_screen),
    )


def _all_of(names: Sequence[str]) -> str:
    return " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)


@dataclass(frozen=True, slots=True)
class Idle:
    """A setting that differs from its default and has no effect."""

    path: Path
    value: object
    use: Use

    def __str__(self) -> str:
        """Return "[screen] speed has no effect here: it has one in Keepaway only"."""
        return f"{shown_path(self.path)} has no effect here: it has one {self.use.where}"

    def problem(self) -> Problem:
        """Return what a reader of the file is told."""
        return Problem(
            self.path,
            f"has no effect in this protocol; it has one {self.use.where}: leave it out",
            self.value,
        )


def uses_of(path: str) -> Iterator[Use]:
    """Yield the entries about a setting, or about a table that it is in."""
    for use in uses():
        if any(path == setting or path.startswith(f"{setting}.") for setting in use.settings):
            yield use


def idle(protocol: Protocol, default: Protocol, modes: Sequence[Mode] = MODES) -> list[Idle]:
    """Return the settings that differ from the defaults, present and former, and have an effect in none of
    these modes.

    Args:
        protocol: any.
        default: of its game.
        modes: how it is to be run.
    """
    found = []
    for path, value in changed(protocol, default):
        name = ".".join(map(str, path))
        if FORMER_DEFAULTS.get(name) == value:
            continue
        for use in uses_of(name):
            if not any(use.when(protocol, mode) for mode in modes):
                found.append(Idle(path, value, use))
                break
    return found


def changed(
    config: msgspec.Struct, default: msgspec.Struct | None, path: Path = ()
) -> Iterator[tuple[Path, object]]:
    """Yield every setting whose value is not the default's, with its path.

    A table of another type counts as changed (its key `type`); what is in it is held against that type's
    defaults.
    """
    same = type(default) is type(config)
    if same and config == default:
        return  # most tables, most of the time: their settings need not be read from the sources
    if not same and default is not None:
        yield (*path, "type"), config.__struct_config__.tag
    for key, setting in settings_of(type(config)).items():
        value = getattr(config, key)
        usual = getattr(default, key) if same else setting.default
        if isinstance(value, msgspec.Struct):
            yield from changed(value, usual if isinstance(usual, msgspec.Struct) else None, (*path, key))
        elif value != usual:
            yield (*path, key), value
