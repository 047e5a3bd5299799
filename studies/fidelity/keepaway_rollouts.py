"""From the reference's logged states onwards: who has the ball so many cycles later, there and in copies of
ours.

Means over whole episodes tell that something differs, not where. Here every comparison starts from the same
state, so that what led to it does not count. Only for a fixed policy with exact state: then the log tells all
that a player knows, but for where it meant to meet the ball, which our players learn by going through the
logged rows one by one.
"""

from collections import defaultdict
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from core.keepaway.autoplay import Autoplay
from core.keepaway.pitch import KICK_DISTANCE, ONGOING
from core.keepaway.simulator.game import step_cycle
from core.keepaway.simulator.match import CLOCK, END, TAKE_COUNT, Match, referee, start_episode
from core.keepaway.simulator.policies import POLICIES
from core.numerics.arrays import Floats
from core.numerics.compiled import specialised
from studies.fidelity.keepaway_fidelity import Setting, read_columns

Start = Literal["drop", "both", "taker", "loose"]
HOLDERS = ("keeper", "both", "taker", "loose", "ended")
"""Who can kick: a keeper, keepers and takers, a taker, nobody; or the episode is over."""
KEEPER, BOTH, TAKER, LOOSE, ENDED = range(5)
LEAST_EXPECTED = 5.0
"""Rarer cases than this are not compared: their errors are not normal."""
RUN_UP = 9
"""Cycles after a drop before the takers, put back to 9.45 m, can be there."""
JUMP_M = 1.5
"""Farther than a player runs in a cycle: a player that moved more was put back."""


@dataclass(frozen=True, slots=True, eq=False)
class LoggedEpisode:
    """One episode of the reference cycle by cycle, T rows: the reset and the state after each cycle but the
    last.
    """

    ball: Floats
    """x, y, vx, vy, shape (T, 4)."""
    players: Floats
    """x, y, vx, vy, body, neck of keepers, then takers, shape (T, n, 6)."""
    kicked: NDArray[np.bool_]
    """Who kicked in the cycle that led to each row, shape (T, n)."""
    n_keepers: int

    def holders(self) -> NDArray[np.int64]:
        """Return who has the ball in each row, shape (T,): indices of HOLDERS."""
        return np.array(
            [
                holder(ball, players, self.n_keepers)
                for ball, players in zip(self.ball, self.players, strict=True)
            ]
        )


@dataclass(frozen=True, slots=True)
class Rollout:
    """From one kind of start: how often a side has the ball so many cycles later."""

    start: Start
    n: int
    cycles: int
    holder: str
    logged: int
    """Starts of the reference after which it is so."""
    expected: float
    """As many in ours."""
    standard_errors: float
    """The difference in its standard errors, episodes being independent; 0 where all copies did as was
    logged."""


def holder(ball: Floats, players: Floats, n_keepers: int) -> int:
    """Return who can kick the ball: an index of HOLDERS."""
    near = np.hypot(players[:, 0] - ball[0], players[:, 1] - ball[1]) < KICK_DISTANCE
    keeper, taker = near[:n_keepers].any(), near[n_keepers:].any()
    if keeper:
        return BOTH if taker else KEEPER
    return TAKER if taker else LOOSE


def read_episodes(path: Path) -> list[LoggedEpisode]:
    """Read the reference's logged trajectories: all complete episodes."""
    column, starts = read_columns(path)
    names = sorted(name[:-2] for name in column if name[0] in "KT" and name.endswith("_x"))
    ball = np.stack([column[c] for c in ("bx", "by", "bvx", "bvy")], axis=1)
    fields = ("x", "y", "vx", "vy", "body", "neck")
    players = np.stack([np.stack([column[f"{n}_{f}"] for f in fields], axis=1) for n in names], axis=1)
    counts = np.stack([column[f"{n}_kicks"] for n in names], axis=1)
    kicked = np.diff(counts, axis=0, prepend=counts[:1]) > 0
    n_keepers = sum(name[0] == "K" for name in names)
    return [LoggedEpisode(ball[a:b], players[a:b], kicked[a:b], n_keepers) for a, b in pairwise(starts)]


def starts_of(episode: LoggedEpisode) -> dict[int, list[Start]]:
    """Return rows to start from, and as what.

    "drop": RUN_UP cycles after a stuck ball was dropped; "both", "taker", "loose": so it is since this row.
    """
    rows: dict[int, list[Start]] = defaultdict(list)
    moved = np.linalg.norm(np.diff(episode.players[:, :, :2], axis=0), axis=2).max(axis=1)
    drops = [int(row) + 1 for row in np.flatnonzero(moved > JUMP_M)]
    for row in drops:
        rows[row + RUN_UP].append("drop")
    names: dict[int, Start] = {BOTH: "both", TAKER: "taker", LOOSE: "loose"}
    holders = episode.holders().tolist()
    for row, (before, now) in enumerate(pairwise(holders), start=1):
        if now != before and now in names and row not in drops:
            rows[row].append(names[now])
    return {row: kinds for row, kinds in rows.items() if row < len(holders) - 1}


def follow(
    setting: Setting, episodes: list[LoggedEpisode], root_seed: int = 11
) -> Iterator[tuple[int, int, Match, Callable[[], bool]]]:
    """Put a match of ours into every logged state but the last of each episode, in order.

    From each it plays one cycle before it gets the next, so that its players remember what they meant to do,
    and `match.commands` are those of the row before.

    Args:
        setting: a fixed policy with exact state, the one that was logged.
        episodes: as logged.
        root_seed: root of the random streams.

    Yields:
        Episode, row, the match, and what plays it one cycle on and says whether that ended the episode.
    """
    if not setting.config.exact_state:
        raise ValueError(f"{setting.label}: with beliefs a logged state does not tell what players know")
    game = Autoplay(setting.config, root_seed, "fidelity rollouts", setting.label)
    match, rules, streams = game.match, game.rules, game.streams
    policy = POLICIES[setting.policy]
    step = specialised(step_cycle, match, rules, policy, streams)

    def play() -> bool:
        return bool(step(match, rules, policy, streams))

    for number, episode in enumerate(episodes):
        start_episode(match, rules, streams.placement)
        status = match.status.copy()
        for row in range(len(episode.ball) - 1):
            match.ball[:], match.players[:] = episode.ball[row], episode.players[row]
            # Nobody is to wait for our own stuck ball: the next drop is far from every start.
            match.stuck[:2], match.stuck[2] = match.ball[:2], match.status[CLOCK]
            if row:
                referee(match.ball, match.players, status, rules)
            match.status[TAKE_COUNT], match.status[END] = status[TAKE_COUNT], ONGOING
            yield number, row, match, play
            play()


def roll_out(
    setting: Setting,
    episodes: list[LoggedEpisode],
    *,
    horizons: tuple[int, ...] = (1, 3, 5, 10, 20),
    copies: int = 60,
) -> list[Rollout]:
    """Play on from every start in the logged episodes, and compare with how they went on.

    Args:
        setting: as `follow`.
        episodes: as logged.
        horizons: cycles after which to look, ascending.
        copies: how often ours goes on from each start.

    Returns:
        Every comparison in which both answers are expected LEAST_EXPECTED times or more.
    """
    found: dict[Start, list[tuple[int, Floats, Floats]]] = defaultdict(list)
    rows, holders = [starts_of(episode) for episode in episodes], [e.holders() for e in episodes]
    for number, row, match, play in follow(setting, episodes):
        if row in rows[number]:
            later = [row + cycles for cycles in horizons]
            known = holders[number]
            logged = one_hot([known[at] if at < len(known) else ENDED for at in later])
            fractions = _fractions(match, horizons, copies, play)
            for kind in rows[number][row]:
                found[kind].append((number, logged, fractions))
    return [rollout for kind in sorted(found) for rollout in _compare(kind, found[kind], horizons)]


def _fractions(match: Match, horizons: tuple[int, ...], copies: int, play: Callable[[], bool]) -> Floats:
    """Return the fraction of copies of the present state in which each has the ball, shape (horizons,
    holders).
    """
    saved = [part.copy() for part in match]
    fractions = np.zeros((len(horizons), len(HOLDERS)))
    for _ in range(copies):
        _put_back(match, saved)
        fractions += one_hot(_went_on(match, horizons, play))
    _put_back(match, saved)
    return fractions / copies


def _put_back(match: Match, saved: list[NDArray[Any]]) -> None:
    for part, kept in zip(match, saved, strict=True):
        part[...] = kept


def one_hot(holders: list[int]) -> Floats:
    """Return one row per holder with a one at its index."""
    return np.eye(len(HOLDERS))[holders]


def _went_on(match: Match, horizons: tuple[int, ...], step: Callable[[], bool]) -> list[int]:
    """Return who has the ball at each horizon."""
    n_keepers = len(match.deciding)
    seen: list[int] = []
    for cycle in range(1, horizons[-1] + 1):
        if step():
            return seen + [ENDED] * (len(horizons) - len(seen))
        if cycle in horizons:
            seen.append(holder(match.ball, match.players, n_keepers))
    return seen


def _compare(
    kind: Start, found: list[tuple[int, Floats, Floats]], horizons: tuple[int, ...]
) -> Iterator[Rollout]:
    episodes = np.array([number for number, _, _ in found])
    logged, fractions = np.array([one for _, one, _ in found]), np.array([one for _, _, one in found])
    for h, cycles in enumerate(horizons):
        for k, name in enumerate(HOLDERS):
            expected = float(fractions[:, h, k].sum())
            if not LEAST_EXPECTED <= expected <= len(found) - LEAST_EXPECTED:
                continue
            difference = logged[:, h, k] - fractions[:, h, k]
            by_episode = np.bincount(episodes, difference)
            error = float(np.sqrt((by_episode**2).sum()))
            yield Rollout(
                kind,
                len(found),
                cycles,
                name,
                int(logged[:, h, k].sum()),
                expected,
                float(difference.sum()) / error if error else 0.0,
            )
