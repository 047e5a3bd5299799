"""What an experimenter decides about a session, in one TOML file. No compiled code is imported.

Every field has a default for each game, and every default names its source, so an empty file is a protocol. The whole
protocol is written to each recording's header, and a session is built from that alone (`core.session.session.build_session`).
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

import msgspec

from core.combination.config import AgentConfig, check_learner
from core.configuration.fields import number
from core.configuration.reading import ConfigurationError, read
from core.feedback.config import CreditConfig, TrainerConfig
from core.feedback.delays import GammaDelay, describe
from core.feedback.keys import KeyConfig
from core.keepaway.participant_config import KeepawayPersonConfig
from core.keepaway.pitch import KeepawayConfig
from core.learners.cross_entropy_config import CrossEntropyConfig
from core.learners.human_config import TileModel
from core.learners.policy_gradient_config import PolicyGradientConfig
from core.learners.sarsa_config import SarsaConfig
from core.session.effects import contradictions, idle
from core.session.protocol_file import ProtocolError, located, read_toml
from core.tetris.config import TetrisConfig

DomainConfig = TetrisConfig | KeepawayConfig
"""What is played; msgspec decodes it by its tag, the field "type"."""
LearnerConfig = CrossEntropyConfig | PolicyGradientConfig | SarsaConfig
"""How the environment's learner learns; decoded by its tag, too."""
LEARNERS: dict[type[DomainConfig], tuple[type[LearnerConfig], ...]] = {
    TetrisConfig: (CrossEntropyConfig, PolicyGradientConfig),
    KeepawayConfig: (SarsaConfig,),
}
"""The learners that can learn each game."""


class SessionConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How many episodes there are, who sees them, and how long they may last."""

    episodes: Annotated[int, number("watched episodes", ge=1, le=1_000_000, usual=(1, 10_000))] = 10
    """Watched episodes."""
    unseen_before: Annotated[int, number("episodes", ge=0, le=10_000_000)] = 0
    """Unseen episodes before the first watched one: 0 shows the agent as it begins."""
    unseen_between: Annotated[int, number("episodes", ge=0, le=10_000_000)] = 100
    """Unseen episodes between two watched ones; 100 are one iteration of the cross-entropy method."""
    watched: Literal["top", "proposed"] = "top"
    """What is watched: one of the top policies, drawn by performance and match, or the learner's next proposal, so
    that watched episodes are the learner's own (`docs/decisions/watched-and-unseen-episodes.md`)."""
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


class ScreenConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How the session looks and how fast it goes."""

    tick_ms: Annotated[int, number("milliseconds", ge=10, le=2000)] = 200
    """Tetris: time per primitive action and per row of gravity, in milliseconds. At 200 a piece takes 1.6 s, and 92 % of
    presses reach theirs under the paper's delay (`docs/decisions/pace-of-a-session.md`; TAMER's demo: 150)."""
    speed: Annotated[float, number("simulated seconds per second", ge=0.05, le=5)] = 1.0
    """Keepaway: simulated seconds per second; below 1 is slow motion. Times of presses and of what was on screen stay
    real. A session of Keepaway plays at 0.2 by default, so that 73 % of a press reach the option it was meant for. (The
    paper plays the simulator at its own speed, 1: there it is 34 %.)"""
    pause_between_episodes_s: Annotated[float, number("seconds", ge=0, le=60)] = 2.0
    """How long the final board of an episode stays, in seconds."""
    count_down_s: Annotated[int, number("seconds", ge=0, le=10)] = 3
    """Count-down before each game, and after a pause, a help page or a window that was too small; 0 leaves it out. No
    step is on screen meanwhile, and no press counts."""
    mark_presses: bool = True
    """Whether the screen marks, for a moment, what an accepted press was taken for: piece or option."""
    show_weight: bool = False
    """Whether participants see the weight that their feedback has. Most studies hide it: it tells the condition."""
    palette: Literal["standard", "colour-blind", "high-contrast", "sixteen"] = "standard"
    """Colours of the pieces; each piece has its own texture, too, outside the standard palette."""

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
"""Whose delay gives credit: as written in the protocol, or of whoever takes part (see `Protocol.delay_of`)."""


class Protocol(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A session, completely."""

    name: str = "default"
    """What the experimenter calls it."""
    domain: DomainConfig = TetrisConfig(placements="reachable")
    """Which game, its size and rules. Tetris: what is shown must be what the paper's four actions can do, hence
    "reachable"."""
    learner: LearnerConfig = CrossEntropyConfig()
    """The environment's learner; each game has its own (`LEARNERS`)."""
    agent: AgentConfig = AgentConfig()
    """How the learner and the participant's feedback are combined."""
    delay_of: DelayOf = "rule"
    """Credit by `agent.credit.delay` ("rule"), by the participant's own measured delay of judging ("feedback-lag"), of
    reacting ("simple"), of judging pooled with others ("pooled"), or by the paper's density ("paper"). All but "rule"
    are replaced by "rule" and its numbers when a session starts, so that a recording needs no other file. The
    rule is the same for every participant, with or without a protocol file
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
    """Further simulated participants of simulated sessions: persons 1, 2, ... The agent has a human model and a weight for
    each. (Section 3.1: "one or more sources"; the paper's sessions have one, and so have live ones.)"""

    def __post_init__(self) -> None:
        known = [str(kind.__struct_config__.tag) for kind in LEARNERS[type(self.domain)]]
        if _tag(self.learner) not in known:
            raise ValueError(
                f"a session of {self.game} has one of the learners {', '.join(known)}, not {_tag(self.learner)}: "
                "set [learner] type"
            )
        if (self.game == "keepaway") != isinstance(self.agent.human_model, TileModel):
            raise ValueError(
                "the human model of Keepaway is of type tiles, that of Tetris is not; got "
                f"{_tag(self.agent.human_model)} for {self.game}: set [agent.human_model] type"
            )
        check_learner(self.agent.scheme, self.learner.kind, _tag(self.learner))
        if isinstance(self.domain, TetrisConfig) and self.domain.lines_in_value:
            raise ValueError(
                "lines_in_value is for given policies in compiled play only: a session's learner sees features "
                "alone. Set [domain] lines_in_value = false"
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
                '[agent.bootstrap.trust] measured = "as-played", and name the chance of a chance-corrected match'
            )

    @property
    def game(self) -> str:
        """Name of the game: "tetris" or "keepaway"."""
        return _tag(self.domain)

    def departures(self) -> list[str]:
        """Return, in plain sentences, where this protocol does otherwise than the paper, or fills its silence."""
        credit, trust = self.agent.credit, self.agent.bootstrap.trust
        session = self.session
        found = [
            "R and H are standardised over the actions of each decision (the paper does not say how they are scaled)",
            f"watched episodes stop after {session.watched_steps} steps, unseen ones after {session.unseen_steps}",
        ]
        if not (isinstance(credit.delay, GammaDelay) and credit.delay == GammaDelay()):
            found.append(f"a press is credited by the rule {describe(credit.delay)}")
        else:
            found.append("gamma(2.5, 0.3) is read as shape and scale: mean 0.75 s, mode 0.45 s, not 0.5 s")
        found.append(f"trust in the human follows the rule {type(trust).__name__}")
        return found + (
            _in_tetris(self.domain) if isinstance(self.domain, TetrisConfig) else self._in_keepaway()
        )

    def _in_keepaway(self) -> list[str]:
        """Return what is particular to Keepaway."""
        assert isinstance(self.domain, KeepawayConfig)
        found = [
            "the simulator is our own, not the RoboCup soccer server (docs/results/keepaway_fidelity.md)",
            "each episode begins a new match: body directions are drawn anew",
            "every episode counts as one policy, because the learner changes all the time",
            f"the human model sees the learner's tiles, {self._shares_human_model()}",
        ]
        if self.screen.speed != 1.0:
            found.append(f"the game is shown at {self.screen.speed:g} times its own speed")
        if self.domain.exact_state:
            found.append("players know the exact state instead of noisy perceptions")
        elif self.domain.see_phases is None:
            found.append(
                "which two of three cycles each player sees in is drawn anew in every episode (the reference: once per match)"
            )
        return found

    def _shares_human_model(self) -> str:
        model = self.agent.human_model
        shared = isinstance(model, TileModel) and model.shared
        return "one model for all keepers" if shared else "one model per keeper"


def _in_tetris(domain: TetrisConfig) -> list[str]:
    """Return what is particular to Tetris."""
    found = ["the symmetric update is made explicit: top policies are drawn by performance and match"]
    if domain.features != "bertsekas-21":
        found.append(f"the environment's learner sees the features {domain.features}")
    return found


def _tag(config: msgspec.Struct) -> str:
    return str(config.__struct_config__.tag)


TETRIS = Protocol()
KEEPAWAY = Protocol(
    domain=KeepawayConfig(),
    learner=SarsaConfig(),
    agent=AgentConfig(
        credit=CreditConfig(delay=GammaDelay()),
        human_model=TileModel(),
    ),
    # Section 4: at most two presses per episode, about 1 in 10 of them wrong.
    keys=KeyConfig(max_presses_per_episode=2),
    trainer=KeepawayPersonConfig().trainer,
    # An untrained team keeps the ball for about 7 s, a trained one for 12 s; a step takes 0.1 s or a pass.
    session=SessionConfig(episodes=20, unseen_between=0, watched_steps=1200, unseen_steps=12000),
    # A pass then takes 3.2 s, in which it can be judged (docs/decisions/pace-of-a-session.md).
    screen=ScreenConfig(speed=0.2),
)
DEFAULTS: dict[str, Protocol] = {"tetris": TETRIS, "keepaway": KEEPAWAY}
"""The default protocol of each game."""


def protocol_from(plain: Mapping[str, Any], *, game: str = "tetris", to_run: bool = False) -> Protocol:
    """Return the protocol that plain types describe: a recording's header, or a TOML file.

    What is not said has the default of the game. A table with another `type` than the default's stands for itself.

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
    default = DEFAULTS.get(str(named), DEFAULTS[game])
    protocol = read(plain, default, to_run=to_run)
    if to_run:
        problems = list(contradictions(protocol))
        problems += [each.problem() for each in idle(protocol, default) if each.use.refused]
        if problems:
            raise ConfigurationError(problems)
    return protocol


def load_protocol(path: Path | None, *, game: str = "tetris") -> Protocol:
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
