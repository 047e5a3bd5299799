"""Everything we say about one participant's reaction times, and the same for a group on several cores."""

from collections.abc import Callable, Mapping
from concurrent.futures import as_completed

import msgspec

from core.feedback.credit import GammaDelay
from core.numerics.streams import stream
from studies.pools import processes
from studies.reaction_time.bootstrap import critical_values, percentile_intervals, resample
from studies.reaction_time.families import FAMILIES, GAMMA, SHIFTED_GAMMA, FamilyFit, compare, fit_all
from studies.reaction_time.goodness import Goodness, goodness_of_fit
from studies.reaction_time.intervals import Interval, profile_intervals
from studies.reaction_time.pooling import FEWEST_PEOPLE, Group, PooledDelay, pool
from studies.reaction_time.quantities import quantities_of
from studies.reaction_time.sample import FitError, Sample

Progress = Callable[[int, int, str], None]
"""Called with (participants done, participants in all, the one just done)."""

WIDEST_SHAPE_RATIO = 4.0
"""The shape counts as identified while the upper end of its interval is at most this many times the lower."""
FEWEST_TRIALS = 20
"""Below this number of responses a fit of one's own is not trusted at all."""


class FitSettings(msgspec.Struct, frozen=True, kw_only=True):
    """What is computed for each participant; stored with the result."""

    families: tuple[str, ...] = tuple(FAMILIES)
    level: float = 0.95
    n_resamples: int = 200
    """Parametric-bootstrap samples per gamma family; 0 leaves the bootstrap out (plain chi-squared
    profiles)."""
    n_goodness: int = 0
    """Resamples of the goodness-of-fit test per gamma family; 0 leaves it out."""
    root_seed: int = 0
    pooled: bool = True
    """Also pool the two-parameter gamma over participants, if there are at least five."""


class DelayEstimate(msgspec.Struct, frozen=True, kw_only=True):
    """A participant's delay density as credit assignment takes it: gamma(shape, scale_s) above offset_s."""

    family: str
    shape: float
    scale_s: float
    offset_s: float
    n_observed: int
    n_censored: int
    estimates: dict[str, float]
    """Shape, scale, offset and the derived mean, mode, sd and quantiles."""
    profile: dict[str, Interval]
    """Profile-likelihood intervals, calibrated by the bootstrap where it was run."""
    bootstrap: dict[str, Interval]
    """Percentile intervals; empty where the bootstrap was left out."""
    shape_identified: bool
    reason: str
    """Why the shape is or is not identified, in one sentence."""
    goodness: Goodness | None = None

    def gamma_delay(self) -> GammaDelay:
        """Return the density that credit assignment takes."""
        return GammaDelay(shape=self.shape, scale_s=self.scale_s, offset_s=self.offset_s)


class ParticipantFit(msgspec.Struct, frozen=True, kw_only=True):
    """All fits of one participant."""

    participant: str
    fits: tuple[FamilyFit, ...]
    """Best AIC first."""
    gamma: DelayEstimate
    """The paper's two-parameter gamma, offset 0."""
    shifted_gamma: DelayEstimate
    verdict: str
    """One plain sentence per gamma family: does another family fit better?"""


class GroupFit(msgspec.Struct, frozen=True, kw_only=True):
    """All participants' fits, in the order they were given."""

    settings: FitSettings
    participants: dict[str, ParticipantFit]
    failures: dict[str, str]
    """Participant to the reason why there is no fit; "(pooled)" to the reason why nobody is pooled."""
    spread: Group | None = None
    """How the participants differ; None where they were not pooled."""
    pooled: dict[str, PooledDelay] = {}
    """Participant to the delay pooled over the group: for few trials each."""


def fit_participant(participant: str, sample: Sample, settings: FitSettings) -> ParticipantFit:
    """Fit every family to one participant's times, with intervals for both gammas.

    The random numbers depend on the root seed and the participant's name only.
    """
    names = dict.fromkeys((*settings.families, GAMMA.name, SHIFTED_GAMMA.name))
    unknown = [name for name in names if name not in FAMILIES]
    if unknown:
        raise ValueError(f"unknown families {unknown}: choose from {list(FAMILIES)}")
    fits = fit_all(sample, tuple(FAMILIES[name] for name in names))
    by_name = {fit.family: fit for fit in fits}
    return ParticipantFit(
        participant=participant,
        fits=fits,
        gamma=estimate_delay(participant, sample, by_name[GAMMA.name], settings),
        shifted_gamma=estimate_delay(participant, sample, by_name[SHIFTED_GAMMA.name], settings),
        verdict=f"{compare(fits, GAMMA.name)} {compare(fits, SHIFTED_GAMMA.name)}",
    )


def estimate_delay(participant: str, sample: Sample, fit: FamilyFit, settings: FitSettings) -> DelayEstimate:
    """Return a gamma or shifted gamma fit with its intervals and the verdict on its shape."""
    bootstrap: dict[str, Interval] = {}
    cuts: dict[str, float] = {}
    if settings.n_resamples:
        rng = stream(settings.root_seed, "reaction-time bootstrap", participant, fit.family)
        resamples = resample(fit, sample, settings.n_resamples, rng=rng)
        bootstrap = percentile_intervals(resamples, level=settings.level)
        cuts = critical_values(fit, resamples, level=settings.level)
    profile = profile_intervals(sample, fit, level=settings.level, cuts=cuts)
    identified, reason = shape_identified(fit, profile["shape"])
    goodness = None
    if settings.n_goodness and not sample.censored_s.size:
        rng = stream(settings.root_seed, "reaction-time goodness", participant, fit.family)
        goodness = goodness_of_fit(sample, fit, rng=rng, n_resamples=settings.n_goodness)
    estimates = quantities_of(fit)
    return DelayEstimate(
        family=fit.family,
        shape=estimates["shape"],
        scale_s=estimates["scale_s"],
        offset_s=estimates["offset_s"],
        n_observed=fit.n_observed,
        n_censored=fit.n_censored,
        estimates=estimates,
        profile=profile,
        bootstrap=bootstrap,
        shape_identified=identified,
        reason=reason,
        goodness=goodness,
    )


def shape_identified(fit: FamilyFit, interval: Interval) -> tuple[bool, str]:
    """Return whether the shape is known well enough to be read as a number, and why, in one sentence."""
    where = f"its {100 * interval.level:g} % interval is {interval.low:.2g} to {interval.high:.2g}"
    ending = " Trust mean and quantiles instead."
    if fit.n_observed < FEWEST_TRIALS:
        return False, f"Shape not identified: {fit.n_observed} responses, fewer than {FEWEST_TRIALS}.{ending}"
    if interval.high_is_bound:
        return False, f"Shape not identified: the data allow any shape above {interval.low:.2g}.{ending}"
    if "shape" in fit.at_bound:
        return (
            False,
            f"Shape not identified: it lies on its bound of 1 at the fastest response; {where}.{ending}",
        )
    if interval.high > WIDEST_SHAPE_RATIO * interval.low:
        return (
            False,
            f"Shape not identified: {where}, a factor of {interval.high / interval.low:.1f}.{ending}",
        )
    return True, f"Shape identified: {where}."


def fit_group(
    samples: Mapping[str, Sample],
    settings: FitSettings,
    *,
    n_workers: int = 1,
    progress: Progress | None = None,
) -> GroupFit:
    """Fit every participant; the result does not depend on the number of workers.

    Args:
        samples: participant to reaction times.
        settings: what to compute.
        n_workers: processes; 1 computes here, without starting any.
        progress: called after each participant.
    """
    done: dict[str, ParticipantFit | str] = {}

    def note(participant: str, outcome: ParticipantFit | str) -> None:
        done[participant] = outcome
        if progress is not None:
            progress(len(done), len(samples), participant)

    if n_workers <= 1:
        for participant, sample in samples.items():
            note(participant, _fit_or_reason(participant, sample, settings))
    else:
        with processes(n_workers) as workers:
            futures = {
                workers.submit(_fit_or_reason, name, sample, settings): name
                for name, sample in samples.items()
            }
            for future in as_completed(futures):
                note(futures[future], future.result())
    fitted = {n: one for n in samples if isinstance(one := done[n], ParticipantFit)}
    spread: Group | None = None
    pooled: dict[str, PooledDelay] = {}
    failures = {n: str(done[n]) for n in samples if n not in fitted}
    if settings.pooled and len(fitted) >= FEWEST_PEOPLE:
        try:
            spread, pooled = pool({n: samples[n] for n in fitted})
        except (ValueError, ArithmeticError) as error:  # LinAlgError is a ValueError
            failures["(pooled)"] = f"pooling failed: {error}"
    return GroupFit(
        settings=settings,
        participants=fitted,
        failures=failures,
        spread=spread,
        pooled=pooled,
    )


def _fit_or_reason(participant: str, sample: Sample, settings: FitSettings) -> ParticipantFit | str:
    try:
        return fit_participant(participant, sample, settings)
    except FitError as error:
        return str(error)
    except (
        ValueError,
        ArithmeticError,
    ) as error:  # numerical trouble with one person must not lose the others
        return f"the fit failed ({type(error).__name__}: {error}); please report these {sample.n} times"
