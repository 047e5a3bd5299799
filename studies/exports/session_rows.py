"""The rows of one recorded session in every tidy table."""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import msgspec

from core.events import (
    CreditGiven,
    EpisodeEnded,
    EpisodeStarted,
    FrameShown,
    KeyPressed,
    PressRetracted,
    ScreenCleared,
    StepTaken,
    TimeGap,
    UnseenPlayed,
)
from core.feedback.delays import describe
from core.numerics.clock import NS_PER_S
from core.recording.reader import Recording
from core.recording.schema import code_of
from core.recording.summary import summarise_recording
from core.recording.upgrade import recorded_version
from core.session.protocol import Protocol
from core.session.protocol_reading import protocol_from
from core.system.foreign_text import printable_json
from studies.exports.columns import Cell, Row
from studies.exports.words import PERFORMANCE_UNITS, action_of, actor_of, piece_of

IMPORTED_CONDITION = "condition "
"""Begins the names of facts in the header by which an imported table was divided."""


@dataclass(slots=True)
class OnScreen:
    """When a step was on screen, nanoseconds of the recording's clock."""

    shown_ns: int | None = None
    hidden_ns: int | None = None
    total_ns: int = 0


@dataclass(frozen=True, slots=True)
class Place:
    """Where an event stands in the session."""

    game: int | None
    """Watched game, from 1."""
    step: int | None
    """Step of that game, from 1."""


class SessionRows:
    """Looks a recording's events up by step and press, and turns them into rows."""

    def __init__(self, recording: Recording, session: str) -> None:
        """Prepare.

        Args:
            recording: one session.
            session: its name in the tables.
        """
        self.recording = recording
        self.session = session
        self.summary = summarise_recording(recording)
        self.game = self.summary.game if self.says_game else ""
        self.places: dict[int, Place] = {}
        """Of each step."""
        self.steps: dict[int, StepTaken] = {}
        self.started: list[EpisodeStarted] = []
        self.ended: dict[int, EpisodeEnded] = {}
        """By episode."""
        self.presses: dict[int, KeyPressed] = {}
        self.retracted: dict[int, PressRetracted] = {}
        self.credit: dict[int, CreditGiven] = {}
        """By press."""
        self.on_screen: dict[int, OnScreen] = {}
        self.frames: dict[int, int] = {}
        """When each frame was flushed, nanoseconds."""
        self._current = -1
        self._since_ns = 0
        for event in recording.events:
            self._note(event)

    @property
    def says_game(self) -> bool:
        """Whether the recording says which game was watched; imported tables of evaluations do not."""
        header = self.recording.header
        return header.origin != "imported" or "domain" in header.protocol

    def _note(self, event: msgspec.Struct) -> None:
        match event:
            case EpisodeStarted():
                self.started.append(event)
                self._in_game = 0
            case StepTaken():
                self._in_game += 1
                self.steps[event.step] = event
                self.places[event.step] = Place(len(self.started), self._in_game)
            case EpisodeEnded():
                self.ended[event.episode] = event
            case KeyPressed():
                self.presses[event.press] = event
            case PressRetracted():
                self.retracted[event.press] = event
            case CreditGiven():
                self.credit[event.press] = event
            case FrameShown():
                self.frames[event.frame] = event.flushed_ns
                self._screen(event.step, event.flushed_ns)
            case ScreenCleared():
                self._screen(-1, event.time_ns)
            case TimeGap():
                self._screen(-1, event.last_ns)
            case _:
                pass

    def _screen(self, step: int, time_ns: int) -> None:
        if step == self._current:
            return
        if self._current >= 0:
            before = self.on_screen[self._current]
            before.hidden_ns = time_ns
            before.total_ns += max(0, time_ns - self._since_ns)
        if step >= 0:
            now = self.on_screen.setdefault(step, OnScreen())
            now.shown_ns = time_ns if now.shown_ns is None else now.shown_ns
        self._current, self._since_ns = step, time_ns

    # --- what all tables share ------------------------------------------------------------------------------

    @cached_property
    def first_columns(self) -> Row:
        """Columns that say whose session this is."""
        header = self.recording.header
        study = header.study
        return {
            "participant": header.participant,
            "session": self.session,
            "study": study.get("study"),
            "condition": self.summary.condition or _imported_condition(header.source),
            "sitting": _from_one(study.get("sitting")),
            "place": _from_one(study.get("place")),
        }

    @cached_property
    def keys(self) -> Row:
        """First columns of the tables of a session."""
        return {**self.first_columns, "origin": self.recording.header.origin, "domain": self.game or None}

    def seconds(self, time_ns: int | None) -> float | None:
        """Return a time in seconds since the session began."""
        return None if time_ns is None else between(self.recording.header.started_ns, time_ns)

    def counted(self, press: int) -> bool:
        """Return whether a press was accepted and not taken back."""
        return self.presses[press].verdict == "accepted" and press not in self.retracted

    def keys_of(self, press: KeyPressed) -> Row:
        """Return the first columns of a press; with the code of whichever of several participants pressed."""
        return {**self.keys, "participant": code_of(self.recording.header, press.person)}

    def action(self, step: int) -> str | None:
        """Return a step's action in words."""
        return action_of(self.game, self.steps[step].detail) if step in self.steps else None

    def piece(self, step: int) -> str | None:
        """Return the letter of a step's piece."""
        return piece_of(self.game, self.steps[step].detail) if step in self.steps else None

    @cached_property
    def protocol(self) -> Protocol | None:
        """The protocol with all its defaults; None where the header's is not one of a session."""
        if not self.says_game:
            return None
        try:
            return protocol_from(self.recording.header.protocol)
        except ValueError:
            return None

    # --- one row, or few ------------------------------------------------------------------------------------

    def session_row(self) -> Row:
        """Return the row of `sessions`."""
        header, held = self.recording.header, self.summary
        times = [time for event in self.recording.events if (time := time_of(event)) is not None]
        unseen = [event for event in self.recording.events if isinstance(event, UnseenPlayed)]
        return {
            **self.keys,
            "created_utc": header.created_utc,
            "duration_s": self.seconds(max(times, default=header.started_ns)),
            "ended": held.ending.kind,
            "games_planned": held.games_planned,
            "games_begun": held.games_begun,
            "games_finished": held.games_finished,
            "games_unseen": sum(len(event.policies) for event in unseen),
            "steps": held.steps,
            "presses_counted": held.presses_counted,
            "presses_retracted": held.presses_taken_back,
            "protocol": held.protocol,
            **self._rules(),
            "root_seed": str(header.root_seed),
            "format_version": recorded_version(header),
            "program_version": header.software.get("arl-tui"),
        }

    def _rules(self) -> Row:
        protocol = self.protocol
        names = ("learner", "scheme", "trust_rule", "human_model", "credit_rule", "credit_scheme")
        if protocol is None or self.recording.header.origin == "imported":
            return dict.fromkeys((*names, "key_good", "key_bad", "max_presses_per_game"))
        agent = protocol.agent
        tags = (protocol.learner, agent.scheme, agent.bootstrap.trust, agent.human_model)
        values: list[Cell] = [str(each.__struct_config__.tag) for each in tags]
        values += [describe(agent.credit.delay), agent.credit.scheme]
        return dict(zip(names, values, strict=True)) | {
            "key_good": protocol.keys.good,
            "key_bad": protocol.keys.bad,
            "max_presses_per_game": protocol.keys.max_presses_per_episode,
        }

    def setting_rows(self) -> Iterator[Row]:
        """Yield the rows of `settings`."""
        plain = (
            self.recording.header.protocol if self.protocol is None else msgspec.to_builtins(self.protocol)
        )
        for path, value in _leaves(plain):
            shown = printable_json(json.dumps(value, ensure_ascii=False))
            yield {**self.first_columns, "setting": path, "value": shown}

    def game_rows(self) -> Iterator[Row]:
        """Yield the rows of `games`, in the order in which they were played."""
        for event in self.recording.events:
            if isinstance(event, EpisodeStarted):
                yield self._watched_row(event)
            elif isinstance(event, UnseenPlayed):
                yield from self._unseen_rows(event)

    def _watched_row(self, started: EpisodeStarted) -> Row:
        number = self.started.index(started) + 1
        ended = self.ended.get(started.episode)
        counted = [
            press
            for press, where in self.press_places.items()
            if where.game == number and self.counted(press)
        ]
        values = [self.presses[press].value or 0.0 for press in counted]
        steps = sum(place.game == number for place in self.places.values())
        return {
            **self.keys,
            "game": number,
            "watched": True,
            "episode_index": started.episode,
            "policy_index": started.policy,
            "performance": None if ended is None else ended.performance,
            "performance_unit": PERFORMANCE_UNITS.get(self.game),
            "steps": steps,
            "ended": None if ended is None else ended.ended,
            "started_s": self.seconds(started.time_ns),
            "ended_s": None if ended is None else self.seconds(ended.time_ns),
            "duration_s": None if ended is None else between(started.time_ns, ended.time_ns),
            "trust_before": started.trust,
            "trust_after": None if ended is None else ended.trust,
            "weight": started.weight,
            "environment_weight": started.w_r,
            "handover": started.handover,
            "shaping": started.shaping,
            "augmentation": started.augmentation,
            "agreed": None if ended is None else ended.agreed,
            "agreed_worst": None if ended is None else ended.agreed_worst,
            "presses_counted": len(counted),
            "presses_good": sum(value > 0 for value in values),
            "presses_bad": sum(value < 0 for value in values),
            "presses_neither": sum(value == 0 for value in values),
        }

    def _unseen_rows(self, event: UnseenPlayed) -> Iterator[Row]:
        watched_only = (
            "game ended started_s ended_s duration_s trust_before environment_weight handover shaping "
            "augmentation presses_counted presses_good presses_bad presses_neither"
        )
        for k, policy in enumerate(event.policies):
            yield {
                **self.keys,
                **dict.fromkeys(watched_only.split()),
                "watched": False,
                "episode_index": event.first_episode + k,
                "policy_index": policy,
                "performance": event.performances[k],
                "performance_unit": PERFORMANCE_UNITS.get(self.game),
                "steps": event.steps[k],
                "trust_after": event.trust,
                "weight": None if event.weights is None else event.weights[k],
                "agreed": event.agreed[k],
                "agreed_worst": event.agreed_worst[k],
            }

    @cached_property
    def press_places(self) -> dict[int, Place]:
        """Game and step on screen at each press."""
        found: dict[int, Place] = {}
        games = 0
        for event in self.recording.events:
            if isinstance(event, EpisodeStarted):
                games += 1
            elif isinstance(event, KeyPressed):
                found[event.press] = self.place_of(event.step, games)
        return found

    def place_of(self, step: int, games: int) -> Place:
        """Return where an input stands: at its step, or after the games that had begun."""
        return self.places.get(step, Place(games or None, None))


def between(first_ns: int, second_ns: int) -> float:
    """Return the time from the first to the second, seconds to the nanosecond."""
    return round((second_ns - first_ns) / NS_PER_S, 9)


def time_of(event: msgspec.Struct) -> int | None:
    """Return when an event happened, in nanoseconds of the recording's clock; None where it has no time."""
    time_ns = getattr(event, "time_ns", getattr(event, "flushed_ns", None))
    return None if time_ns is None else int(time_ns)


def step_actor(game: str, detail: Mapping[str, int]) -> str | None:
    """Return who acted in a step."""
    return actor_of(game, detail)


def _imported_condition(source: Mapping[str, str]) -> str | None:
    """Return the columns by which an imported table was divided, such as `task=coffee; set=data`."""
    names = [name for name in source if name.startswith(IMPORTED_CONDITION)]
    return "; ".join(f"{name.removeprefix(IMPORTED_CONDITION)}={source[name]}" for name in names) or None


def _from_one(number: str | None) -> int | None:
    return int(number) + 1 if number and number.isdecimal() else None


def _leaves(value: Any, path: str = "") -> Iterator[tuple[str, Any]]:
    if isinstance(value, Mapping) and value:
        for name, below in value.items():
            yield from _leaves(below, f"{path}.{name}" if path else str(name))
    elif path:
        yield path, value
