"""Credit rule x scheme: what each combination would have learned from one recording, and how well it
plays.
"""

import dataclasses
import itertools
import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray

from core.combination.agent import ArlAgent
from core.combination.human_learner import HumanLearner
from core.combination.schemes import SCHEMES, AnnealedWeight, Per, Scheme
from core.events import CreditGiven, KeyPressed, PressRetracted
from core.feedback.credit import Delay, describe
from core.numerics.streams import stream, stream_seed
from core.recording.joined import read_session
from core.recording.reader import Recording
from core.registry import game_of
from core.session.protocol import Protocol
from core.session.what_if import WatchedStep, relearn, replay_human_model, watched_steps
from studies.pools import processes
from studies.statistics import Interval, mean_interval, paired_difference

HELD_OUT = 0.2
"""Fraction of the accepted presses, the last ones, on which the human model is tested."""


@dataclass(frozen=True, slots=True)
class WhatIfSettings:
    """What is to be compared, and how carefully."""

    games: int = 100
    """Fresh games played with the resulting policy."""
    piece_cap: int = 5500
    """A game is stopped after this many pieces: TAMER's evaluations were (100,000 atomic actions)."""
    root_seed: int = 0
    """Of the evaluation games and of everything random in an imported recording."""


@dataclass(frozen=True, slots=True)
class HeldOut:
    """How well a human model foretells presses that it was not trained on."""

    log_loss: float
    """Nats per press, >= 0; NaN where `undefined` says why."""
    of_the_rate: float
    """The same for a constant guess, the rate of praise among the training presses."""
    undefined: str = ""
    """Why there is no log-loss, in words; "" where there is one."""

    @property
    def worse(self) -> bool:
        """Whether the model foretells worse than the constant guess."""
        return self.log_loss > self.of_the_rate


@dataclass(frozen=True, slots=True, kw_only=True)
class WhatIfRow:
    """One line of the table."""

    credit: str
    scheme: str
    per: Per | None
    """What the scheme's weight falls with; None where it does not fall."""
    trust: tuple[float, ...]
    """What the rule of trust said after each watched episode."""
    episode: int
    """Number of the episode that the agent was judged as, from 0: the one it would play next."""
    watched: int
    """How many of the episodes before were watched."""
    weight: float
    """Weight w_h of the participant's values that the scheme used where the agent was judged."""
    handover: float
    """Probability of handing the choice to the human model there (control sharing), else 0."""
    shaping: float
    """Reward per unit of H there (reward shaping), else 0."""
    held_out: HeldOut
    """How well the human model foretells the last presses."""
    credited: float
    """Share of the presses' mass that fell on steps; NaN where no press counted."""
    lines: Interval
    """Lines per game (Keepaway: seconds) of the resulting policy on fresh seeds, with a 95 % bootstrap
    interval."""
    difference: Interval | None
    """Lines per game minus those of the table's first row, paired by seed, with a 95 % bootstrap interval;
    None in the first row."""
    capped: float
    """Fraction of games stopped by the cap."""

    @property
    def rule(self) -> str:
        """The scheme as `scheme_named` takes it, such as `annealed:episode`."""
        return self.scheme if self.per is None else f"{self.scheme}:{self.per}"


def what_if(
    path: Path,
    protocol: Protocol,
    delays: Iterable[Delay],
    schemes: Iterable[str],
    settings: WhatIfSettings,
    *,
    workers: int = 1,
    on_progress: Callable[[], None] = lambda: None,
) -> list[WhatIfRow]:
    """Return a row per credit rule and scheme, in that order; the same rows for any number of workers.

    Args:
        path: the recording.
        protocol: of the agents; credit and scheme are replaced by the ones asked for.
        delays: credit rules.
        schemes: as `scheme_named` takes them.
        settings: games and seeds.
        workers: processes; 1 works in this one.
        on_progress: called after every finished row.
    """
    tasks = [
        (path, _with(protocol, delay, scheme), settings)
        for delay, scheme in itertools.product(tuple(delays), tuple(schemes))
    ]
    if workers == 1 or len(tasks) == 1:
        return _compared([_noted(_row(*task), on_progress) for task in tasks], settings)
    with processes(workers) as pool:
        futures = [pool.submit(_row, *task) for task in tasks]
        return _compared([_noted(future.result(), on_progress) for future in futures], settings)


Judged = tuple[WhatIfRow, NDArray[np.float64]]
"""A row, and the lines of each game."""


def _noted(judged: Judged, on_progress: Callable[[], None]) -> Judged:
    on_progress()
    return judged


def _compared(judged: list[Judged], settings: WhatIfSettings) -> list[WhatIfRow]:
    """Return the rows with their differences to the first one: all have played the same seeds."""
    (first, control), *others = judged
    return [first] + [
        dataclasses.replace(
            row,
            difference=paired_difference(
                lines, control, rng=stream(settings.root_seed, "what-if", "bootstrap")
            ),
        )
        for row, lines in others
    ]


def scheme_named(name: str, own: Scheme) -> Scheme:
    """Return the scheme that a name means, with its defaults.

    Args:
        name: from `core.combination.config.SCHEMES`; one whose weight falls may say with what:
            `annealed:watched-game`, `annealed:episode`.
        own: the protocol's; its settings count where its own name is asked for.

    Raises:
        ValueError: there is no such scheme, or its weight does not fall so.
    """
    tag, colon, per = name.partition(":")
    if tag not in SCHEMES:
        raise ValueError(f"unknown scheme {tag!r}: use one of {', '.join(SCHEMES)}")
    kind = SCHEMES[tag]
    scheme = own if isinstance(own, kind) else kind()
    if not colon:
        return scheme
    falling = [tag for tag, kind in SCHEMES.items() if issubclass(kind, AnnealedWeight)]
    if not isinstance(scheme, AnnealedWeight):
        raise ValueError(  # noqa: TRY004 - the text is wrong, not its type
            f"{name!r}: the weight of {tag} does not fall; those of {', '.join(falling)} do"
        )
    if per not in ("watched-game", "episode"):
        raise ValueError(f"{name!r}: a weight falls per watched-game or per episode, as in {tag}:episode")
    return msgspec.structs.replace(scheme, per=per)


def _with(protocol: Protocol, delay: Delay, scheme: str) -> Protocol:
    if delay != protocol.agent.credit.delay:
        # A rule that is asked for holds for all; under the protocol's own each participant keeps theirs.
        people = tuple(msgspec.structs.replace(person, delay=None) for person in protocol.people)
        protocol = msgspec.structs.replace(protocol, people=people)
    agent = msgspec.structs.replace(
        protocol.agent,
        credit=msgspec.structs.replace(protocol.agent.credit, delay=delay),
        scheme=scheme_named(scheme, protocol.agent.scheme),
    )
    return msgspec.structs.replace(protocol, agent=agent)


def _row(path: Path, protocol: Protocol, settings: WhatIfSettings) -> Judged:
    recording = read_session(path)
    steps = watched_steps(recording, protocol)
    imported = recording.header.origin == "imported"
    root_seed = settings.root_seed if imported else recording.header.root_seed
    relearned = relearn(recording, protocol, steps, root_seed=root_seed)
    agent, scheme = relearned.agent, protocol.agent.scheme
    account, judged = agent.human.account, agent.final_policy()
    lines, capped = judge(agent, protocol, settings)
    row = WhatIfRow(
        credit=describe(protocol.agent.credit.delay),
        scheme=str(scheme.__struct_config__.tag),
        per=scheme.per if isinstance(scheme, AnnealedWeight) else None,
        trust=tuple(relearned.trust),
        episode=judged.episode,
        watched=agent.so_far.watched,
        weight=judged.episode_weights.w_h,
        handover=judged.episode_weights.handover,
        shaping=judged.episode_weights.shaping,
        held_out=held_out_log_loss(recording, protocol, steps),
        credited=account.credited / account.presses if account.presses else math.nan,
        lines=mean_interval(lines, rng=stream(settings.root_seed, "what-if", "bootstrap")),
        difference=None,
        capped=capped,
    )
    return row, lines


def judge(agent: ArlAgent, protocol: Protocol, settings: WhatIfSettings) -> tuple[NDArray[np.float64], float]:
    """Play fresh games as the agent's next episode would be played; every agent plays the same seeds.

    Returns:
        Performance per game, shape (games,), and the fraction of games that the cap stopped.
    """
    seeds = [stream_seed(settings.root_seed, "what-if", "game", game) for game in range(settings.games)]
    played = game_of(protocol).evaluate(protocol, agent, seeds, max_steps=settings.piece_cap)
    lines = np.array([game.performance for game in played])
    return lines, sum(game.ended == "truncation" for game in played) / len(played)


def held_out_log_loss(recording: Recording, protocol: Protocol, steps: dict[int, WatchedStep]) -> HeldOut:
    """Return how badly the human model foretells the last presses, and how badly a constant guess does.

    The model is trained on the first 80 % of the accepted presses. A press's score is the model's value of
    the steps it is about, weighted by credit; scores become probabilities of praise by a logistic curve
    fitted to the training presses (Platt 1999). Presses without any credit are left out on both sides.

    There is no log-loss where either part has no presses or the training part knows only one kind; the result
    says so.
    """
    if protocol.people:
        return HeldOut(math.nan, math.nan, "several people: each has a human model of their own")
    presses = _standing_presses(recording)
    training = set(list(presses)[: round(len(presses) * (1 - HELD_OUT))])
    model = replay_human_model(recording, protocol, steps, count=training.__contains__).human
    credits = replay_human_model(recording, protocol, steps, count=presses.__contains__).credits
    train: list[tuple[float, bool]] = []
    test: list[tuple[float, bool]] = []
    for given in credits:
        score = _score(given, model, steps)
        if score is not None:
            (train if given.press in training else test).append((score, presses[given.press] > 0))
    undefined = _why_undefined(len(presses), train, test)
    if undefined:
        return HeldOut(math.nan, math.nan, undefined)
    return HeldOut(_platt_log_loss(train, test), _rate_log_loss(train, test))


def _why_undefined(n_presses: int, train: list[tuple[float, bool]], test: list[tuple[float, bool]]) -> str:
    """Return why nothing can be foretold; "" where it can."""
    if not n_presses:
        return "no press counted"
    if not train:
        return f"none of the first presses (of {n_presses}) reached a step, so there is nothing to learn from"
    if len({praise for _, praise in train}) < 2:
        kind = "praise" if train[0][1] else "blame"
        return f"{len(train)} presses to learn from, all of them {kind}: it takes both kinds"
    if not test:
        return f"none of the last presses (of {n_presses}) reached a step, so there is nothing to foretell"
    return ""


def _standing_presses(recording: Recording) -> dict[int, float]:
    """Return the value of every accepted press that was not taken back, in order of time.

    Presses of value 0 are left out: they are neither praise nor blame.
    """
    standing = {
        event.press: event.value
        for event in recording.inputs
        if isinstance(event, KeyPressed) and event.verdict == "accepted" and event.value
    }
    for event in recording.inputs:
        if isinstance(event, PressRetracted):
            standing.pop(event.press, None)
    return standing


def _score(given: CreditGiven, human: HumanLearner, steps: dict[int, WatchedStep]) -> float | None:
    """Return the model's value of what a press is about; None where that is not known."""
    parts = [
        (share, float(human.model.predict(steps[step].taken[None, :])[0]))
        for step, share in zip(given.steps, given.shares, strict=True)
        if np.isfinite(steps[step].taken).all()
    ]
    total = sum(share for share, _ in parts)
    return sum(share * value for share, value in parts) / total if total > 0 else None


def _platt_log_loss(train: list[tuple[float, bool]], test: list[tuple[float, bool]]) -> float:
    """Fit P(praise) = sigmoid(a + b score) on `train`, return the mean log-loss on `test`."""
    from scipy.optimize import minimize  # here, not above: half a second that only this needs

    scores = np.array([score for score, _ in train])
    scale = float(scores.std()) or 1.0
    centre = float(scores.mean())
    standard = (scores - centre) / scale
    praised = np.array([praise for _, praise in train])
    # Platt's targets keep the curve finite where the scores separate the two kinds.
    n_good, n_bad = int(praised.sum()), int((~praised).sum())
    targets = np.where(praised, (n_good + 1) / (n_good + 2), 1 / (n_bad + 2))

    def loss(curve: NDArray[np.float64]) -> float:
        logits = curve[0] + curve[1] * standard
        return float(np.mean(np.logaddexp(0.0, logits) - targets * logits))

    offset, slope = minimize(loss, np.zeros(2), method="BFGS").x
    logits = np.array([offset + slope * (score - centre) / scale for score, _ in test])
    praised_then = np.array([praise for _, praise in test])
    return float(np.mean(np.logaddexp(0.0, np.where(praised_then, -logits, logits))))


def _rate_log_loss(train: list[tuple[float, bool]], test: list[tuple[float, bool]]) -> float:
    """Return the mean log-loss on `test` of always guessing the rate of praise in `train`."""
    rate = (sum(praise for _, praise in train) + 1) / (len(train) + 2)
    return -sum(math.log(rate if praise else 1 - rate) for _, praise in test) / len(test)
