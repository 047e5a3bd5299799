"""From finished trials to a participant's delays: runs in a process of its own, because statistics load
slowly.

The screen's process imports `FitOrder` and `Fitted` only; everything heavy is imported inside the functions.
"""

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from arl_tui.calibration.plan import newest_complete
from arl_tui.participants import LATE_MS, Quantity, TaskDelay, keep_delay
from core.feedback.delays import GammaDelay
from core.numerics.clock import seconds, wall_time_utc
from studies.reaction_time.protocol import Task, TrialRecord
from studies.reaction_time.trial_log import TrialFileError, read_trials

if TYPE_CHECKING:
    from studies.reaction_time.exclusion import Selection
    from studies.reaction_time.fit import DelayEstimate, ParticipantFit
    from studies.reaction_time.sample import Sample


class FitOrder(msgspec.Struct, frozen=True, kw_only=True):
    """What is to be fitted."""

    recordings: str
    participant: str
    files: tuple[str, ...]
    """One finished session per task."""


class Fitted(msgspec.Struct, frozen=True, kw_only=True):
    """What came of it."""

    delays: tuple[TaskDelay, ...] = ()
    failures: dict[str, str] = {}
    """Task to the reason why there is no fit."""
    kept_in: str = ""
    """Where the delays are kept."""


def fit_files(order: FitOrder) -> Fitted:
    """Fit and keep each task's delay; a task that cannot be fitted does not stop the others."""
    from studies.reaction_time.sample import FitError

    recordings = Path(order.recordings)
    delays: list[TaskDelay] = []
    failures: dict[str, str] = {}
    kept_in = ""
    for name in order.files:
        path = Path(name)
        config = read_trials(path).header.schedule.config
        task, game = config.task, config.game
        try:
            others = _others(order.participant, recordings, task, game)
        except TrialFileError as error:  # another participant's file
            others = {}
            failures[f"{task}, pooled"] = str(error)
        try:
            delay = fit_task(path, others, order.participant, task)
        except FitError as error:
            failures[task] = str(error)
            continue
        except ValueError as error:  # numerical trouble in one task must not lose the others
            failures[task] = f"the fit failed ({error}); the trials are kept"
            continue
        kept_in = str(keep_delay(recordings, order.participant, delay))
        delays.append(delay)
    return Fitted(delays=tuple(delays), failures=failures, kept_in=kept_in)


def fit_task(path: Path, others: "Mapping[str, Sample]", participant: str, task: Task) -> TaskDelay:
    """Return one participant's delay in one task, on its own and pooled with others who have done it.

    Args:
        path: a finished session.
        others: other participants' times in the same task.
        participant: whose session it is.
        task: which.

    Raises:
        FitError: too few usable responses.
    """
    from studies.reaction_time.fit import FitSettings, fit_participant

    sample, selection = _sample_of(path, participant)
    settings = FitSettings(pooled=False)
    fit = fit_participant(participant, sample, settings)
    better = _better_gamma(fit)
    pooled, people = _pooled(participant, sample, others)
    file = read_trials(path)
    header, facts = file.header, file.header.facts
    return TaskDelay(
        task=task,
        game=header.schedule.config.game,
        fitted_utc=wall_time_utc(),
        files=(path.name,),
        family=better.family,
        delay=better.gamma_delay(),
        mean_s=_quantity(better, "mean_s"),
        median_s=_quantity(better, "q50_s"),
        n_observed=better.n_observed,
        n_censored=better.n_censored,
        left_out={
            verdict: count
            for verdict, count in selection.counts[participant].items()
            if verdict not in ("kept", "timed out")
        },
        policy=msgspec.to_builtins(selection.policy),
        shape_identified=better.shape_identified,
        shape_reason=better.reason,
        verdict=fit.verdict,
        connection={k: facts[k] for k in ("connection", "multiplexer", "hindrances") if k in facts},
        n_late=sum(is_late(record) for record in file.trials if not record.practice),
        pooled=pooled,
        pooled_people=people,
    )


def is_late(record: TrialRecord) -> bool:
    """Return whether the stimulus left the program much later than the foreperiod ended: its loop was held
    up.
    """
    if record.flushed_ns is None:
        return False
    late_s = seconds(record.flushed_ns - record.started_ns) - record.foreperiod_s
    return 1000.0 * late_s > LATE_MS


def _sample_of(path: Path, participant: str) -> "tuple[Sample, Selection]":
    from studies.reaction_time.exclusion import ExclusionPolicy, select
    from studies.reaction_time.read import read_rows
    from studies.reaction_time.sample import FitError

    samples, selection = select(read_rows([path]), ExclusionPolicy())
    if participant not in samples:
        raise FitError(selection.unusable.get(participant, f"{path}: no trials of {participant}"))
    return samples[participant], selection


def _better_gamma(fit: "ParticipantFit") -> "DelayEstimate":
    """Return the gamma with the lower AIC; the paper's where they are equal."""
    aic = {family.family: family.aic for family in fit.fits}
    return fit.gamma if aic[fit.gamma.family] <= aic[fit.shifted_gamma.family] else fit.shifted_gamma


def _quantity(estimate: "DelayEstimate", name: str) -> Quantity:
    interval = estimate.profile[name]
    return Quantity(estimate.estimates[name], interval.low, interval.high)


def _pooled(participant: str, own: "Sample", others: "Mapping[str, Sample]") -> tuple[GammaDelay | None, int]:
    """Return the delay pooled over all who have finished the task, and how many they are; None below five."""
    from studies.reaction_time.pooling import FEWEST_PEOPLE, pool

    samples = {**others, participant: own}
    if len(samples) < FEWEST_PEOPLE:
        return None, len(samples)
    _, pooled = pool(samples)
    return pooled[participant].gamma_delay(), len(samples)


def _others(participant: str, recordings: Path, task: Task, game: str) -> "Mapping[str, Sample]":
    from studies.reaction_time.exclusion import ExclusionPolicy, select
    from studies.reaction_time.read import read_rows

    paths = list(newest_complete(recordings, task, game))
    samples, _ = select(read_rows(paths), ExclusionPolicy())
    return {name: sample for name, sample in samples.items() if name != participant}


def main() -> None:
    """Read an order from the standard input, write what came of it to the standard output, both JSON."""
    order = msgspec.json.decode(sys.stdin.buffer.read(), type=FitOrder)
    try:
        fitted = fit_files(order)
    except (TrialFileError, OSError) as error:
        fitted = Fitted(failures={"all": str(error)})
    sys.stdout.buffer.write(msgspec.json.encode(fitted))


if __name__ == "__main__":
    main()
