"""`arl train`: let keepers learn out of sight, and keep what they have learned."""

import secrets
import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from arl_tui.command_line import NumberRange, ToWrite, say
from arl_tui.commands.watch import keepers_option, region_option, takers_option, task, vision_option

if TYPE_CHECKING:
    from core.keepaway.training import LearningCurve, LearningRun
    from core.learners.sarsa import Sarsa


@click.command(short_help="Let keepers learn by Sarsa, unseen, and keep the policy.")
@click.argument("game", type=click.Choice(["keepaway"]), default="keepaway")
@click.option(
    "--save",
    type=ToWrite(),
    required=True,
    help="Where the policy is kept, such as keepers.npz.",
)
@click.option(
    "--hours", type=NumberRange(0.01, 1000.0), default=2.0, show_default=True, help="Simulated hours."
)
@click.option("--seed", type=click.IntRange(0, 2**63 - 1), help="Root seed; a new one by default.")
@keepers_option
@takers_option
@region_option
@vision_option
@click.option(
    "--shared/--independent", default=False, show_default=True, help="All keepers learn one policy."
)
@click.option(
    "--trace-decay", type=NumberRange(0.0, 1.0), default=0.0, show_default=True, help="lambda of Sarsa."
)
def train(
    game: str,
    save: Path,
    hours: float,
    seed: int | None,
    keepers: int | None,
    takers: int | None,
    size: tuple[float, float] | None,
    vision: str | None,
    shared: bool,
    trace_decay: float,
) -> None:
    """Let keepers learn by Sarsa, out of sight, and keep what they have learned.

    The same seed gives the same policy. An hour of play takes a second or so.
    """
    from arl_tui.commands.exact import GETTING_READY
    from core.learners.sarsa import SarsaConfig

    config = task(None, keepers=keepers, takers=takers, size=size, vision=vision)
    learner = SarsaConfig(shared_weights=shared, trace_decay=trace_decay)
    say(GETTING_READY, err=True)
    from core.keepaway.training import LearningRun

    run = LearningRun(config, learner, secrets.randbits(63) if seed is None else seed, hours)
    sarsa, blocks = with_progress(run)
    from core.keepaway.policy_file import N_LAST

    durations = [float(duration) for block in blocks for duration in block.duration_s]
    write(save, run, sarsa, durations)
    means = f"{mean(durations):.1f} s"
    if len(durations) >= 2 * N_LAST:
        first, last = mean(durations[:N_LAST]), mean(durations[-N_LAST:])
        means = f"{first:.1f} s over the first {N_LAST}, {last:.1f} s over the last {N_LAST}"
    say(f"{len(durations):,} episodes in {hours:g} simulated hours; mean duration {means}")
    say(f"Policy: {save}")
    say(f"Look at it: {shlex.join(['arl', 'watch', 'keepaway', '--policy', str(save)])}")


def with_progress(run: "LearningRun") -> "tuple[Sarsa, list[LearningCurve]]":
    """Train, with a bar that shows how far it is."""
    from core.keepaway.training import train
    from core.numerics.clock import S_PER_HOUR

    blocks: list[LearningCurve] = []
    total = round(run.hours * S_PER_HOUR)
    with click.progressbar(length=total, label="Learning", file=sys.stderr) as bar:

        def note(block: "LearningCurve") -> None:
            blocks.append(block)
            bar.update(round(float(block.duration_s.sum())))

        return train(run, note), blocks


def write(save: Path, run: "LearningRun", sarsa: "Sarsa", durations: list[float]) -> None:
    """Write the policy file; stop with a message where that fails."""
    from arl_tui.app import facts
    from core.keepaway.policy_file import N_LAST, PolicyHeader, SavedPolicy, save_policy
    from core.numerics.clock import wall_time_utc

    header = PolicyHeader(
        task=run.config,
        learner=run.learner,
        n_tilings=sarsa.coder.n_tilings,
        root_seed=run.root_seed,
        hours=run.hours,
        episodes=len(durations),
        duration_s=mean(durations[-N_LAST:]),
        created_utc=wall_time_utc(),
        software=facts.software(),
    )
    try:
        save_policy(save, SavedPolicy(header, sarsa.weights))
    except OSError as error:
        raise click.ClickException(f"the policy cannot be written: {error}") from error


def mean(values: list[float]) -> float:
    """Return the mean of at least one value."""
    return sum(values) / len(values)
