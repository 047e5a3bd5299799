"""How closely the Keepaway simulator follows the reference: durations, ends, passes, flights, first kicks.

The reference is the RoboCup server with the UT Austin players; its episodes are tables of durations and ends,
and for some settings logged trajectories. Both sides go through the same functions.
"""

import csv
import gzip
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from scipy import stats

from core.keepaway.autoplay import Autoplay
from core.keepaway.pitch import BALL_DECAY, CYCLE_S, KICK, KICK_DISTANCE, KIND, KeepawayConfig
from core.keepaway.simulator.game import step_cycle
from core.keepaway.simulator.match import start_episode
from core.keepaway.simulator.policies import POLICIES
from core.numerics.arrays import Bools, Floats
from core.numerics.compiled import specialised

RELEASE_SPEED = 0.7
"""Speed, metres per cycle, above which a ball that leaves a keeper's reach counts as passed."""
TOLERANCE = 0.10
"""Targets: of means and fine statistics relative, of the K-S distance and the part that ends outside
absolute."""
TRACED_EPISODES = 4000
"""So many that what is left of a difference is the reference's own sampling error (300 logged episodes)."""
FINE_NAMES = ("passes per episode", "release speed", "flight cycles", "first kick cycle")
TABLE_HEAD = (
    "setting",
    "policy",
    "n (ours / reference)",
    "mean s",
    "difference",
    "in s.e.",
    "K-S",
    "fraction out",
)


@dataclass(frozen=True, slots=True)
class Setting:
    """One condition that was measured on the reference."""

    name: str
    """As in the names of the reference's files."""
    policy: str
    config: KeepawayConfig
    short: str
    """Name of the policy in the names of the files."""

    @property
    def label(self) -> str:
        """Return e.g. "v15_360_hold", the start of the reference's file names."""
        return f"{self.name}_{self.short}"


_POLICY_FILES = (("random", "rand"), ("hold", "hold"), ("hand", "hand"))
_LOGGED_PHASES = {"random": (2, 2, 2, 1, 1), "hold": (1, 1, 0, 1, 2), "hand": (0, 0, 0, 0, 0)}
"""In which cycles each player sees, K1..K3, T1, T2: as the players of the logged matches joined, kept for the
whole match.

Read from the logs' commands; an initial condition of those runs, not of the game."""
SETTINGS = tuple(
    Setting(name, policy, config, short)
    for policy, short in _POLICY_FILES
    for name, config in (
        ("v15_full", KeepawayConfig(exact_state=True)),
        ("v15_360", KeepawayConfig(see_phases=_LOGGED_PHASES[policy])),
    )
)
DRAWN_PHASES = tuple(Setting("v15_360", policy, KeepawayConfig(), short) for policy, short in _POLICY_FILES)
"""The settings with beliefs as sessions and experiments play them: phases drawn in each episode."""


@dataclass(frozen=True, slots=True, eq=False)
class Durations:
    """How long n episodes lasted and how they ended."""

    seconds: Floats
    """Shape (n,)."""
    out: Bools
    """Whether the ball left the region, shape (n,)."""

    def __post_init__(self) -> None:
        if self.seconds.shape != self.out.shape or len(self.seconds) < 2:
            raise ValueError(
                f"need at least two episodes with an end each, got {len(self.seconds)} and {len(self.out)}"
            )


@dataclass(frozen=True, slots=True)
class Trace:
    """One episode cycle by cycle, T + 1 rows: the reset and the state after each logged cycle."""

    ball: Floats
    """x, y, vx, vy, shape (T + 1, 4)."""
    keepers: Floats
    """x, y of each keeper, shape (T + 1, k, 2)."""
    kicked: Bools
    """Whether a keeper kicked in the cycle that led to the row, shape (T + 1, k)."""


@dataclass(frozen=True, slots=True)
class DurationComparison:
    """Ours against the reference for one setting."""

    setting: Setting
    ours: Durations
    reference: Durations

    @property
    def relative_difference(self) -> float:
        """Return (our mean - reference mean) / reference mean of the durations."""
        reference = float(self.reference.seconds.mean())
        return (float(self.ours.seconds.mean()) - reference) / reference

    @property
    def standard_errors(self) -> float:
        """Return the difference of the means in standard errors of the difference."""
        parts = [d.seconds.var(ddof=1) / len(d.seconds) for d in (self.ours, self.reference)]
        difference = float(self.ours.seconds.mean() - self.reference.seconds.mean())
        return difference / float(np.sqrt(sum(parts)))

    @property
    def ks_distance(self) -> float:
        """Return the two-sample Kolmogorov-Smirnov distance of the durations.

        Durations are whole cycles: 24 * 0.1 and 2.4 read from a table have to be equal, or each step counts
        as a distance.
        """
        ours, reference = (np.rint(d.seconds / CYCLE_S) for d in (self.ours, self.reference))
        return float(stats.ks_2samp(ours, reference).statistic)

    @property
    def out_difference(self) -> float:
        """Return our fraction of episodes that end outside minus the reference's."""
        return float(self.ours.out.mean() - self.reference.out.mean())


def read_durations(path: Path) -> Durations:
    """Read the reference's table of episodes (columns duration_s and end_reason)."""
    with path.open() as lines:
        rows = list(csv.DictReader(lines))
    if not rows or not {"duration_s", "end_reason"} <= rows[0].keys():
        raise ValueError(f"{path}: need rows with duration_s and end_reason, got {rows[:1]}")
    return Durations(
        np.array([float(row["duration_s"]) for row in rows]),
        np.array([row["end_reason"] == "out" for row in rows]),
    )


def read_columns(path: Path) -> tuple[dict[str, Floats], list[int]]:
    """Read the reference's logged trajectories: columns by name, and the rows in which episodes start."""
    with gzip.open(path, "rt") as lines:
        names = next(csv.reader(lines))
        rows = np.loadtxt(lines, delimiter=",")
    column = {name: rows[:, k] for k, name in enumerate(names)}
    starts = np.flatnonzero(np.diff(column["episode"], prepend=np.nan) != 0)
    return column, starts.tolist()


def read_traces(path: Path) -> list[Trace]:
    """Read the reference's logged trajectories: one trace per complete episode."""
    column, starts = read_columns(path)
    keepers = sorted(name[:-2] for name in column if name.startswith("K") and name.endswith("_x"))
    ball = np.stack([column[c] for c in ("bx", "by", "bvx", "bvy")], axis=1)
    places = np.stack([np.stack([column[f"{k}_x"], column[f"{k}_y"]], 1) for k in keepers], 1)
    counts = np.stack([column[f"{k}_kicks"] for k in keepers], 1)
    traces = []
    for a, b in pairwise(starts):
        kicked = np.diff(counts[a:b], axis=0, prepend=counts[a : a + 1]) > 0
        traces.append(Trace(ball[a:b], places[a:b], kicked))
    return traces


def play_cycles(game: Autoplay, policy: int, n_episodes: int) -> Iterator[tuple[Floats, Floats, Bools]]:
    """Play episodes cycle by cycle; yield of each what the reference's logs keep: all rows but the last.

    Args:
        game: at the start of its first episode.
        policy: number of a fixed policy (`core.keepaway.simulator.policies`).
        n_episodes: how many.

    Yields:
        The ball, shape (cycles, 4), the players, shape (cycles, n_players, columns), and who had
        kicked, shape (cycles, n_players).
    """
    match, rules, streams = game.match, game.rules, game.streams
    step = specialised(step_cycle, match, rules, policy, streams)
    for episode in range(n_episodes):
        if episode:
            start_episode(match, rules, streams.placement)
        balls, players = [match.ball.copy()], [match.players.copy()]
        kicked = [np.zeros(len(match.players), np.bool_)]
        while not step(match, rules, policy, streams):
            balls.append(match.ball.copy())
            players.append(match.players.copy())
            kicked.append(match.commands[:, KIND] == KICK)
        yield np.array(balls), np.array(players), np.array(kicked)


def play_traces(setting: Setting, n_episodes: int, root_seed: int) -> list[Trace]:
    """Play episodes and keep what the reference's logs keep of ball and keepers."""
    game = Autoplay(setting.config, root_seed, "fidelity traces", setting.label)
    k = setting.config.n_keepers
    return [
        Trace(ball, players[:, :k, :2], kicked[:, :k])
        for ball, players, kicked in play_cycles(game, POLICIES[setting.policy], n_episodes)
    ]


def passes_of(trace: Trace) -> list[tuple[float, int]]:
    """Return (release speed in metres per cycle, flight in cycles) of every pass of an episode.

    A pass starts with a keeper's kick after which the ball leaves his reach fast; it flies until one of the
    keepers has it in reach again or the episode ends. A ball that is dropped, and its keepers put back, has
    no speed.
    """
    gaps = np.linalg.norm(trace.keepers - trace.ball[:, None, :2], axis=2)
    speeds = np.linalg.norm(trace.ball[:, 2:], axis=1) / BALL_DECAY
    n = len(trace.ball)
    found: list[tuple[float, int]] = []
    row = 1
    while row < n:
        kickers = np.flatnonzero(trace.kicked[row])
        left = [k for k in kickers if gaps[row, k] > KICK_DISTANCE and speeds[row] > RELEASE_SPEED]
        if not left:
            row += 1
            continue
        end = row
        while end < n and not (gaps[end] < KICK_DISTANCE).any():
            end += 1
        found.append((float(speeds[row]), end - row))
        row = max(end, row + 1)
    return found


def fine_statistics(traces: list[Trace]) -> dict[str, float]:
    """Return the means named in FINE_NAMES."""
    passes = [passes_of(trace) for trace in traces]
    every = [one for some in passes for one in some]
    first = [int(np.argmax(t.kicked.any(1))) for t in traces if t.kicked.any()]
    values = (
        np.mean([len(some) for some in passes]),
        np.mean([speed for speed, _ in every]) if every else 0.0,
        np.mean([flight for _, flight in every]) if every else 0.0,
        np.mean(first),
    )
    return dict(zip(FINE_NAMES, map(float, values), strict=True))


def play_durations(setting: Setting, n_episodes: int, root_seed: int) -> Durations:
    """Play whole episodes in compiled code."""
    game = Autoplay(setting.config, root_seed, "fidelity", setting.label)
    episodes = game.play(setting.policy, n_episodes)
    return Durations(episodes.duration_s, episodes.out)


def compare(setting: Setting, folder: Path, n_episodes: int, root_seed: int) -> DurationComparison:
    """Play a setting and put it beside the reference's episodes in `folder`."""
    reference = read_durations(folder / f"{setting.label}_episodes.csv")
    return DurationComparison(setting, play_durations(setting, n_episodes, root_seed), reference)


def compare_fine(
    setting: Setting, folder: Path, root_seed: int
) -> tuple[dict[str, float], dict[str, float]] | None:
    """Return our and the reference's fine statistics; None where no trajectories were logged."""
    path = folder / f"{setting.label}_traj.csv.gz"
    if not path.exists():
        return None
    ours = fine_statistics(play_traces(setting, TRACED_EPISODES, root_seed))
    return ours, fine_statistics(read_traces(path))


def table_row(comparison: DurationComparison) -> tuple[str, ...]:
    """Return one row under TABLE_HEAD; bold where a target is missed."""
    ours, reference = comparison.ours, comparison.reference
    relative = comparison.relative_difference
    missed = abs(relative) >= TOLERANCE and abs(comparison.standard_errors) >= 2
    return (
        comparison.setting.name,
        comparison.setting.policy,
        f"{len(ours.seconds)} / {len(reference.seconds)}",
        f"{ours.seconds.mean():.2f} / {reference.seconds.mean():.2f}",
        _bold_if(missed, f"{100 * relative:+.1f} %"),
        f"{comparison.standard_errors:+.1f}",
        _bold_if(comparison.ks_distance >= TOLERANCE, f"{comparison.ks_distance:.3f}"),
        _bold_if(
            abs(comparison.out_difference) >= TOLERANCE,
            f"{ours.out.mean():.2f} / {reference.out.mean():.2f}",
        ),
    )


def fine_row(setting: Setting, ours: dict[str, float], reference: dict[str, float]) -> tuple[str, ...]:
    """Return one row of fine statistics, under setting, policy and FINE_NAMES; bold where missed."""
    cells = []
    for name in FINE_NAMES:
        relative = ours[name] / reference[name] - 1
        difference = _bold_if(abs(relative) > TOLERANCE, f"({100 * relative:+.0f} %)")
        cells.append(f"{ours[name]:.2f} / {reference[name]:.2f} {difference}")
    return (setting.name, setting.policy, *cells)


def _bold_if(missed: bool, text: str) -> str:
    return f"**{text}**" if missed else text


def write_figure(comparison: DurationComparison, path: Path) -> None:
    """Draw both distributions of durations as step functions."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5.0, 3.2), layout="constrained")
    axes = figure.subplots()
    for durations, name, color, line in (
        (comparison.reference, "reference", "black", "--"),
        (comparison.ours, "this simulator", "tab:blue", "-"),
    ):
        seconds = np.sort(durations.seconds)
        axes.step(
            seconds,
            np.arange(1, len(seconds) + 1) / len(seconds),
            where="post",
            label=name,
            color=color,
            linestyle=line,
        )
    axes.set(
        xlabel="duration of an episode (s)",
        ylabel="share of episodes",
        title=f"{comparison.setting.name}, {comparison.setting.policy}",
        xlim=(0, float(np.quantile(comparison.reference.seconds, 0.99))),
    )
    axes.legend(loc="lower right", frameon=False)
    figure.savefig(path, dpi=110)
