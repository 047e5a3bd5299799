"""What an experimenter decides about a session, in one TOML file. No compiled code is imported.

Every field has a default for each game, and every default names its source, so an empty file is a protocol.
The whole protocol is written to each recording's header, and a session is built from that alone
(`core.session.session.build_session`).
"""

from collections.abc import Iterator, Mapping
from typing import Annotated, ClassVar, Literal

import msgspec

from core.combination.config import AgentConfig, check_learner
from core.configuration.catalogue import tag_of
from core.configuration.fields import number
from core.feedback.config import CreditConfig, TrainerConfig
from core.feedback.delays import GammaDelay, describe
from core.feedback.keys import KeyConfig
from core.feedback.people import (
    MOST_PEOPLE,
    PersonConfig,
    check_people,
    credit_of_person,
    keys_of_person,
)
from core.learners.cross_entropy_config import CrossEntropyConfig
from core.learners.policy_gradient_config import PolicyGradientConfig
from core.learners.sarsa_config import SarsaConfig
from core.plugins import DomainConfig, is_game, plugin_called, plugin_of
from core.recording.schema import FIRST_GAME

ENOUGH_REACH = 0.70
"""A session in which a smaller fraction of presses reaches the step they are meant for says so before it
starts, and `arl protocol --check` advises another pace (docs/decisions/pace-of-a-session.md)."""
LearnerConfig = CrossEntropyConfig | PolicyGradientConfig | SarsaConfig
"""How the environment's learner learns; msgspec decodes it by its tag, the field "type"."""


class SessionConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How many episodes there are, who sees them, and how long they may last."""

    episodes: Annotated[int, number("watched episodes", ge=1, le=1_000_000, usual=(1, 10_000))] = 10
    """Watched episodes."""
    unseen_before: Annotated[int, number("episodes", ge=0, le=10_000_000)] = 0
    """Unseen episodes before the first watched one: 0 shows the agent as it begins."""
    unseen_between: Annotated[int, number("episodes", ge=0, le=10_000_000)] = 100
    """Unseen episodes between two watched ones; 100 are one iteration of the cross-entropy method."""
    watched: Literal["top", "proposed"] = "top"
    """What is watched: one of the top policies, drawn by performance and match, or the learner's next
    proposal, so that watched episodes are the learner's own
    (`docs/decisions/watched-and-unseen-episodes.md`)."""
    watched_steps: Annotated[int, number("steps", ge=1, le=1_000_000_000, usual=(1, 1_000_000))] = 60
    """A watched episode is truncated after this many steps (a good policy would play for hours)."""
    unseen_steps: Annotated[int, number("steps", ge=1, le=1_000_000_000)] = 5000
    """An unseen episode is truncated after this many steps."""

    def __post_init__(self) -> None:
        for name in ("episodes", "watched_steps", "unseen_steps"):
            if getattr(self, name) < 1:
                raise ValueError(f"{name} is >= 1, got {getattr(self, name)}")
        for name in ("unseen_before", "unseen_between"):
            if getattr(self, name) < 0:
                raise ValueError(f"{name} is >= 0, got {getattr(self, name)}")


Language = Literal["en", "de"]
"""Languages of the participants' screens, by ISO 639. `docs/how-to/language-and-keys.md`
says how another one is added."""


class ScreenConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How the session looks and how fast it goes."""

    tick_ms: Annotated[int, number("milliseconds", ge=10, le=2000)] = 200
    """Tetris: time per primitive action and per row of gravity, in milliseconds. At 200 a piece takes 1.6 s,
    and 92 % of presses reach theirs under the paper's delay (`docs/decisions/pace-of-a-session.md`; TAMER's
    demo: 150)."""
    speed: Annotated[float, number("simulated seconds per second", ge=0.05, le=5)] = 1.0
    """Keepaway: simulated seconds per second; below 1 is slow motion. Times of presses and of what was on
    screen stay real. A session of Keepaway plays at 0.2 by default, so that 73 % of a press reach the option
    it was meant for. (The paper plays the simulator at its own speed, 1: there it is 34 %.)"""
    pause_between_episodes_s: Annotated[float, number("seconds", ge=0, le=60)] = 2.0
    """How long the final board of an episode stays, in seconds."""
    count_down_s: Annotated[int, number("seconds", ge=0, le=10)] = 3
    """Count-down before each game, and after a pause, a help page or a window that was too small; 0 leaves it
    out. No step is on screen meanwhile, and no press counts."""
    mark_presses: bool = True
    """Whether the screen marks, for a moment, what an accepted press was taken for: piece or option."""
    show_weight: bool = False
    """Whether participants see the weight that their feedback has. Most studies hide it: it tells the
    condition."""
    palette: Literal["standard", "colour-blind", "high-contrast", "sixteen"] = "standard"
    """Colours of the pieces; each piece has its own texture, too, outside the standard palette."""
    theme: Literal["dark", "light", "high-contrast"] = "dark"
    """Colours of all pages. `--theme` or the environment variable ARL_THEME overrules it on one computer.
    "high-contrast" also takes the palette of that name, unless the protocol chooses one with textures."""
    reduced_motion: bool = False
    """Leave out movement that carries no information: Keepaway is drawn cycle by cycle, without what lies
    between."""
    games_per_stretch: Annotated[int, number("watched games", ge=1, le=1_000_000)] = 1
    """Watched games that follow one another without a count-down: one stretch. Keepaway's games may last
    three seconds, which is too short for a count-down each."""
    games_per_block: Annotated[int, number("watched games", ge=0, le=1_000_000)] = 0
    """After so many watched games a page offers a break that waits for the participant; 0: none."""

    language: Language = "en"
    """Language of everything that the participant reads: "en" is English, "de" German. The environment
    variable LANG does not change it (`docs/decisions/languages.md`)."""

    LATER: ClassVar[frozenset[str]] = frozenset(
        {"theme", "reduced_motion", "games_per_stretch", "games_per_block", "language"}
    )
    """Settings that came after version 0.2: at their defaults they are not written to recordings."""

    def __post_init__(self) -> None:
        if not 10 <= self.tick_ms <= 2000:
            raise ValueError(f"tick_ms is 10..2000 milliseconds, got {self.tick_ms}")
        if not 0.05 <= self.speed <= 5.0:
            raise ValueError(f"speed is 0.05..5 simulated seconds per second, got {self.speed}")
        if not 0.0 <= self.pause_between_episodes_s <= 60.0:
            raise ValueError(
                f"pause_between_episodes_s is 0..60 seconds, got {self.pause_between_episodes_s}"
            )
        if not 0 <= self.count_down_s <= 10:
            raise ValueError(f"count_down_s is 0..10 whole seconds, got {self.count_down_s}")


DelayIfMissing = Literal["refuse", "pooled", "paper"]
"""What a participant has whose delay was not measured (see `Protocol.delay_if_missing`)."""
DelayOf = Literal["rule", "feedback-lag", "simple", "pooled", "paper"]
"""Whose delay gives credit: as written in the protocol, or the participant's own (see
`Protocol.delay_of`)."""


class Protocol(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A session, completely."""

    name: str = "default"
    """What the experimenter calls it."""
    domain: DomainConfig = msgspec.field(default_factory=lambda: DEFAULTS[FIRST_GAME].domain)
    """Which game, its size and rules. Tetris: what is shown must be what the paper's four actions can do,
    hence "reachable"."""
    learner: LearnerConfig = CrossEntropyConfig()
    """The environment's learner; each game has its own (`core.plugins.GamePlugin.learners`)."""
    agent: AgentConfig = AgentConfig()
    """How the learner and the participant's feedback are combined."""
    delay_of: DelayOf = "rule"
    """Credit by `agent.credit.delay` ("rule"), by the participant's own measured delay of judging
    ("feedback-lag"), of reacting ("simple"), of judging pooled with others ("pooled"), or by the paper's
    density ("paper"). All but "rule" are replaced by "rule" and its numbers when a session starts, so that a
    recording needs no other file. The rule is the same for every participant, with or without a protocol file
    (`docs/decisions/one-rule-of-credit.md`)."""
    delay_if_missing: DelayIfMissing = "refuse"
    """Where `delay_of` names a measured delay and the participant has none: the session does not start
    ("refuse"), credit goes by the delay of judging of the others in the same recordings folder ("pooled", at
    least five), or by the paper's density ("paper")."""
    keys: KeyConfig = KeyConfig()
    """Which presses count."""
    session: SessionConfig = SessionConfig()
    """How many games there are."""
    screen: ScreenConfig = ScreenConfig()
    """How the session looks and how fast it goes."""
    trainer: TrainerConfig = TrainerConfig()
    """The simulated participant of demonstrations and of simulated sessions."""
    others: Annotated[tuple[TrainerConfig, ...], msgspec.Meta(max_length=100)] = ()
    """Further simulated participants of simulated sessions: persons 1, 2, ... The agent has a human model and
    a weight for each. With `people` they are those after the first; a person without one is simulated as
    `trainer` says."""
    people: Annotated[tuple[PersonConfig, ...], msgspec.Meta(max_length=MOST_PEOPLE)] = ()
    """Several people at one keyboard, each with keys of their own. The agent has a human model and a weight
    for each (section 3.1: "one or more sources"; the paper's sessions have one). []: one, with [keys]."""

    LATER: ClassVar[frozenset[str]] = frozenset({"people"})
    """Settings that came after version 0.2: at their defaults they are not written to recordings."""

    def __post_init__(self) -> None:
        plugin = plugin_of(self)
        known = [tag_of(kind) for kind in plugin.learners]
        if tag_of(self.learner) not in known:
            raise ValueError(
                f"a session of {self.game} has one of the learners {', '.join(known)}, not "
                f"{tag_of(self.learner)}: "
                "set [learner] type"
            )
        models = [tag_of(kind) for kind in plugin.human_models]
        if tag_of(self.agent.human_model) not in models:
            raise ValueError(
                f"the human model of {self.game} is of type {' or '.join(models)}, not "
                f"{tag_of(self.agent.human_model)}: set [agent.human_model] type"
            )
        check_learner(self.agent.scheme, self.learner.kind, tag_of(self.learner))
        plugin.check(self)
        check_people(self.people, self.keys)
        if self.people and len(self.others) >= len(self.people):
            raise ValueError(
                f"others are the people after the first: at most {len(self.people) - 1}, got "
                f"{len(self.others)}"
            )
        needs = self.agent.bootstrap.trust.needs
        if needs.side_by_side:
            raise ValueError(
                "a session has one learner, learners side by side play in experiments only "
                "(core.keepaway.arl_autoplay): set another [agent.bootstrap.trust] type"
            )
        if needs.window and self.learner.kind == "stepwise":
            raise ValueError(
                "a policy that changes at every step cannot be asked again about earlier decisions: set "
                '[agent.bootstrap.trust] measured = "as-played", and name the chance of a chance-corrected match'  # noqa: E501
            )

    @property
    def game(self) -> str:
        """Name of the game, as in `core.plugins.GamePlugin.name`."""
        return str(self.domain.__struct_config__.tag)

    @property
    def n_participants(self) -> int:
        """How many participants the agent listens to, >= 1."""
        return len(self.people) or 1 + len(self.others)

    @property
    def participants(self) -> list[str] | msgspec.UnsetType:
        """Codes of the people at the keyboard, for a recording's header; not set without `people`."""
        return [person.name for person in self.people] or msgspec.UNSET

    @property
    def keys_of_people(self) -> tuple[KeyConfig, ...]:
        """Keys and limits of each person at the keyboard, in order; of one without `people` [keys]."""
        return tuple(keys_of_person(person, self.keys) for person in self.people) or (self.keys,)

    @property
    def credit_of_participants(self) -> tuple[CreditConfig, ...]:
        """How the presses of each participant become samples, in order, one per `n_participants`."""
        if not self.people:
            return (self.agent.credit,) * self.n_participants
        return tuple(credit_of_person(person, self.agent.credit) for person in self.people)

    def departures(self) -> list[str]:
        """Return, in plain sentences, where this protocol does otherwise than the paper, or fills its
        silence.
        """
        credit, trust = self.agent.credit, self.agent.bootstrap.trust
        session = self.session
        found = [
            (
                "R and H are standardised over the actions of each decision (the paper does not say how they "
                "are scaled)"
            ),
            (
                f"watched episodes stop after {session.watched_steps} steps, unseen ones after "
                f"{session.unseen_steps}"
            ),
        ]
        if not (isinstance(credit.delay, GammaDelay) and credit.delay == GammaDelay()):
            found.append(f"a press is credited by the rule {describe(credit.delay)}")
        else:
            found.append("gamma(2.5, 0.3) is read as shape and scale: mean 0.75 s, mode 0.45 s, not 0.5 s")
        found.append(f"trust in the participant follows the rule {type(trust).__name__}")
        return found + plugin_of(self).departures(self)


class _Defaults(Mapping[str, Protocol]):
    """The default protocol of each game that can be played, by the game's name, or "game:variant"."""

    def __getitem__(self, game: str) -> Protocol:
        name, _, variant = game.partition(":")
        if not is_game(name):
            raise KeyError(game)
        plugin = plugin_called(name)
        default: Protocol = plugin.default_of(variant) if variant else plugin.default()
        return default

    def __iter__(self) -> Iterator[str]:
        return iter(DomainConfig.structs())

    def __len__(self) -> int:
        return len(DomainConfig.structs())


DEFAULTS: Mapping[str, Protocol] = _Defaults()
"""The default protocol of each game."""
