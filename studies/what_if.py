"""Credit rule x scheme: what each combination would have learned from one recording, and how well it plays."""

import itertools
import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray

from core.combination.config import SCHEMES
from core.combination.human_learner import HumanLearner
from core.episode import CreditGiven, KeyPressed, PressRetracted
from core.feedback.credit import Delay, describe
from core.games import game_of
from core.protocol import Protocol
from core.recording.reader import Recording, read_recording
from core.streams import stream, stream_seed
from core.what_if import Relearned, WatchedStep, hear, relearn, watched_steps
from studies.pools import processes
from studies.statistics import Interval, mean_interval

HELD_OUT = 0.2
"""Share of the accepted presses, the last ones, on which the human model is tested."""


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
class WhatIfRow:
    """One line of the table."""

    credit: str
    scheme: str
    w_h: tuple[float, ...]
    """Human weight after each watched episode."""
    log_loss: float
    """Held-out log-loss of the human model, nats per press; NaN with too few presses."""
    log_loss_of_the_rate: float
    """The same for a guess that knows only how often the person praised."""
    credited: float
    """Share of the presses' mass that fell on steps."""
    lines: Interval
    """Lines per game (Keepaway: seconds) of the resulting policy on fresh seeds, with a 95 % bootstrap interval."""
    capped: float
    """Share of games stopped by the cap."""


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
        schemes: names from `core.combination.config.SCHEMES`.
        settings: games and seeds.
        workers: processes; 1 works in this one.
        on_progress: called after every finished row.
    """
    tasks = [
        (path, _with(protocol, delay, scheme), settings)
        for delay, scheme in itertools.product(tuple(delays), tuple(schemes))
    ]
    if workers == 1 or len(tasks) == 1:
        return [_noted(_row(*task), on_progress) for task in tasks]
    with processes(workers) as pool:
        futures = [pool.submit(_row, *task) for task in tasks]
        return [_noted(future.result(), on_progress) for future in futures]


def _noted(row: WhatIfRow, on_progress: Callable[[], None]) -> WhatIfRow:
    on_progress()
    return row


def _with(protocol: Protocol, delay: Delay, scheme: str) -> Protocol:
    if scheme not in SCHEMES:
        raise ValueError(f"unknown scheme {scheme!r}: use one of {', '.join(SCHEMES)}")
    kind = SCHEMES[scheme]
    current = protocol.agent.scheme
    agent = msgspec.structs.replace(
        protocol.agent,
        credit=msgspec.structs.replace(protocol.agent.credit, delay=delay),
        scheme=current if isinstance(current, kind) else kind(),
    )
    return msgspec.structs.replace(protocol, agent=agent)


def _row(path: Path, protocol: Protocol, settings: WhatIfSettings) -> WhatIfRow:
    recording = read_recording(path)
    steps = watched_steps(recording, protocol)
    imported = recording.header.origin == "imported"
    root_seed = settings.root_seed if imported else recording.header.root_seed
    relearned = relearn(recording, protocol, steps, root_seed=root_seed)
    account = relearned.agent.human.account
    lines, capped = _evaluate(relearned, protocol, settings)
    log_loss, of_the_rate = held_out_log_loss(recording, protocol, steps)
    return WhatIfRow(
        credit=describe(protocol.agent.credit.delay),
        scheme=next(name for name, kind in SCHEMES.items() if isinstance(protocol.agent.scheme, kind)),
        w_h=tuple(relearned.w_h),
        log_loss=log_loss,
        log_loss_of_the_rate=of_the_rate,
        credited=account.credited / account.presses if account.presses else math.nan,
        lines=mean_interval(lines, rng=stream(settings.root_seed, "what-if", "bootstrap")),
        capped=capped,
    )


def _evaluate(
    relearned: Relearned, protocol: Protocol, settings: WhatIfSettings
) -> tuple[NDArray[np.float64], float]:
    """Play fresh games with what was learned; every row plays the same seeds."""
    seeds = [stream_seed(settings.root_seed, "what-if", "game", game) for game in range(settings.games)]
    played = game_of(protocol).evaluate(
        protocol, relearned.agent, seeds, max_steps=settings.piece_cap, episode=len(relearned.w_h)
    )
    lines = np.array([game.performance for game in played])
    return lines, sum(game.ended == "truncation" for game in played) / len(played)


def held_out_log_loss(
    recording: Recording, protocol: Protocol, steps: dict[int, WatchedStep]
) -> tuple[float, float]:
    """Return how badly the human model foretells the last presses, and how badly a constant guess does.

    The model is trained on the first 80 % of the accepted presses. A press's score is the model's value of the
    steps it speaks of, weighted by credit; scores become probabilities of praise by a logistic curve fitted to the
    training presses (Platt 1999). Presses without any credit are left out on both sides.

    Returns:
        Log-loss in nats per press of the model and of the training presses' rate of praise; NaN where either
        part has no presses or the training part knows only one kind.
    """
    presses = _standing_presses(recording)
    training = set(list(presses)[: round(len(presses) * (1 - HELD_OUT))])
    model = hear(recording, protocol, steps, count=training.__contains__).human
    credits = hear(recording, protocol, steps, count=presses.__contains__).credits
    train: list[tuple[float, bool]] = []
    test: list[tuple[float, bool]] = []
    for given in credits:
        score = _score(given, model, steps)
        if score is not None:
            (train if given.press in training else test).append((score, presses[given.press] > 0))
    if not test or len({praise for _, praise in train}) < 2:
        return math.nan, math.nan
    return _platt_log_loss(train, test), _rate_log_loss(train, test)


def _standing_presses(recording: Recording) -> dict[int, float]:
    """Return the value of every accepted press that was not taken back, in order of time."""
    standing = {
        event.press: event.value
        for event in recording.inputs
        if isinstance(event, KeyPressed) and event.verdict == "accepted" and event.value is not None
    }
    for event in recording.inputs:
        if isinstance(event, PressRetracted):
            standing.pop(event.press, None)
    return standing


def _score(given: CreditGiven, human: HumanLearner, steps: dict[int, WatchedStep]) -> float | None:
    """Return the model's value of what a press speaks of; None where it speaks of nothing that is known."""
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
