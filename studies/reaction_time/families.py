"""Densities of reaction times: their likelihoods and maximum-likelihood fits.

Every fit looks for the highest point of the likelihood over a stated region, not for the nearest stop of an
optimiser: `scipy.stats.gamma.fit` with a free offset ends thousands of log-units too low on real data. The
offset of a shifted family stays in 0 <= offset < fastest response; see `kernels` for the bounds that keep the
likelihood finite.
"""

import math
from collections.abc import Sequence
from typing import Any

import msgspec
import numpy as np
from scipy import stats

from core.numerics.arrays import Floats
from studies.reaction_time import kernels
from studies.reaction_time.ascent import climb
from studies.reaction_time.censored import fit_censored
from studies.reaction_time.family import Family
from studies.reaction_time.kernels import SMALLEST_WIDTH_S
from studies.reaction_time.sample import Sample

_BOUND_TOLERANCE = 1e-6


class FamilyFit(msgspec.Struct, frozen=True, kw_only=True):
    """One family at its maximum likelihood."""

    family: str
    parameters: dict[str, float]
    """By name; names ending in `_s` are seconds, `mu` of the log-normal is log-seconds, others have no
    unit."""
    log_likelihood: float
    """Natural log, densities per second; time-outs count with their probability."""
    n_observed: int
    n_censored: int
    aic: float
    """-2 log-likelihood + 2 parameters."""
    bic: float
    """-2 log-likelihood + parameters * log(trials)."""
    at_bound: tuple[str, ...] = ()
    """Parameters that lie on the edge of the allowed region."""


def _offset(p: Sequence[Any]) -> Any:
    return p[2] if len(p) > 2 else 0.0


def _freeze_gamma(p: Sequence[Any]) -> Any:
    return stats.gamma(p[0], loc=_offset(p), scale=p[1])


def _freeze_log_normal(p: Sequence[Any]) -> Any:
    return stats.lognorm(p[1], loc=_offset(p), scale=np.exp(p[0]))


def _freeze_wald(p: Sequence[Any]) -> Any:
    return stats.invgauss(np.divide(p[0], p[1]), loc=_offset(p), scale=p[1])


def _freeze_weibull(p: Sequence[Any]) -> Any:
    return stats.weibull_min(p[0], loc=_offset(p), scale=p[1])


def _freeze_ex_gaussian(p: Sequence[Any]) -> Any:
    return stats.exponnorm(np.divide(p[2], p[1]), loc=p[0], scale=p[1])


GAMMA = Family("gamma", ("shape", "scale_s"), kernels.GAMMA, 0.0, _freeze_gamma)
SHIFTED_GAMMA = Family(
    "shifted gamma", ("shape", "scale_s", "offset_s"), kernels.GAMMA, kernels.SHIFTED_SHAPE_MIN, _freeze_gamma
)
EX_GAUSSIAN = Family("ex-Gaussian", ("mu_s", "sigma_s", "tau_s"), None, 0.0, _freeze_ex_gaussian)
FAMILIES: dict[str, Family] = {
    family.name: family
    for family in (
        GAMMA,
        SHIFTED_GAMMA,
        EX_GAUSSIAN,
        Family("log-normal", ("mu", "sigma"), kernels.LOG_NORMAL, 0.0, _freeze_log_normal),
        Family(
            "shifted log-normal",
            ("mu", "sigma", "offset_s"),
            kernels.LOG_NORMAL,
            kernels.SHIFTED_SIGMA_MAX,
            _freeze_log_normal,
        ),
        Family("Wald", ("mean_s", "lambda_s"), kernels.WALD, 0.0, _freeze_wald),
        Family("shifted Wald", ("mean_s", "lambda_s", "offset_s"), kernels.WALD, 0.0, _freeze_wald),
        Family("Weibull", ("shape", "scale_s"), kernels.WEIBULL, 0.0, _freeze_weibull),
        Family(
            "shifted Weibull",
            ("shape", "scale_s", "offset_s"),
            kernels.WEIBULL,
            kernels.SHIFTED_SHAPE_MIN,
            _freeze_weibull,
        ),
    )
}
"""All families by name. `mean_s` of the Wald is counted from the offset."""


def distribution(fit: FamilyFit) -> Any:
    """Return scipy's frozen distribution of a fit."""
    family = FAMILIES[fit.family]
    return family.freeze(family.values(fit.parameters))


def log_likelihood(family: Family, parameters: Sequence[float], sample: Sample) -> float:
    """Return the log-likelihood: log density of responses plus log survival of time-outs."""
    frozen = family.freeze(parameters)
    total = float(frozen.logpdf(sample.observed_s).sum())
    if sample.censored_s.size:
        total += float(frozen.logsf(sample.censored_s).sum())
    return total


def fit_family(family: Family, sample: Sample) -> FamilyFit:
    """Return the family's maximum-likelihood fit.

    Args:
        family: one of `FAMILIES`.
        sample: the participant's reaction times; time-outs count as right-censored.

    Raises:
        FitError: where a censored fit does not converge.
    """
    if sample.censored_s.size:
        values, total = fit_censored(family, sample)
    else:
        values, total = fit_observed(family, sample.observed_s)
    return _summary(family, values, total, sample)


def fit_observed(family: Family, observed_s: Floats) -> tuple[Floats, float]:
    """Return (parameters in the family's order, log-likelihood) for fully observed times."""
    if family.kernel is None:
        return _fit_ex_gaussian(observed_s)
    out = np.zeros(3)
    if family.shifted:
        total = kernels.fit_shifted(observed_s, family.kernel, family.bound, out)
        return out, float(total)
    total = kernels.fit_at_offset(observed_s, 0.0, family.kernel, family.bound, out)
    return out[:2].copy(), float(total)


def fit_all(sample: Sample, families: Sequence[Family] = tuple(FAMILIES.values())) -> tuple[FamilyFit, ...]:
    """Return every family's fit, best AIC first."""
    return tuple(sorted((fit_family(family, sample) for family in families), key=lambda fit: fit.aic))


def compare(fits: Sequence[FamilyFit], name: str) -> str:
    """Say in one sentence how a family compares with the best of `fits` by AIC."""
    chosen = next((fit for fit in fits if fit.family == name), None)
    if chosen is None:
        raise ValueError(f"no fit of the {name!r} among {[fit.family for fit in fits]}: fit it too")
    best = min(fits, key=lambda fit: fit.aic)
    lead = chosen.aic - best.aic
    if lead <= 0.0:
        return (
            f"The {name} describes these times best of the {len(fits)} families tried (AIC {chosen.aic:.1f})."
        )
    evidence = "hardly" if lead < 2.0 else "somewhat" if lead < 10.0 else "clearly"
    ending = "; the two cannot be told apart." if lead < 2.0 else "."
    return f"The {best.family} fits {evidence} better than the {name}: its AIC is {lead:.1f} lower{ending}"


def _summary(family: Family, values: Floats, total: float, sample: Sample) -> FamilyFit:
    n_parameters = len(family.parameters)
    return FamilyFit(
        family=family.name,
        parameters={name: float(value) for name, value in zip(family.parameters, values, strict=True)},
        log_likelihood=total,
        n_observed=sample.observed_s.size,
        n_censored=sample.censored_s.size,
        aic=-2.0 * total + 2.0 * n_parameters,
        bic=-2.0 * total + n_parameters * math.log(sample.n),
        at_bound=_at_bound(family, values, float(sample.observed_s[0])),
    )


def _at_bound(family: Family, values: Floats, low: float) -> tuple[str, ...]:
    found = []
    if family.kernel is None:
        found += [
            n for n, v in zip(family.parameters[1:], values[1:], strict=True) if v < 1.01 * SMALLEST_WIDTH_S
        ]
    elif family.shifted:
        if family.kernel in (kernels.GAMMA, kernels.WEIBULL) and values[0] < family.bound + _BOUND_TOLERANCE:
            found.append("shape")
        if family.kernel == kernels.LOG_NORMAL and values[1] > family.bound - _BOUND_TOLERANCE:
            found.append("sigma")
        if values[2] < _BOUND_TOLERANCE or low - values[2] < _BOUND_TOLERANCE:
            found.append("offset_s")
    return tuple(found)


def _fit_ex_gaussian(x: Floats) -> tuple[Floats, float]:
    """Climb from several fractions of the variance in tau; keep the highest top. Unknowns: mu / sd, logs of
    widths.
    """
    mean, sd = float(x.mean()), float(x.std())
    low = [-math.inf, math.log(SMALLEST_WIDTH_S), math.log(SMALLEST_WIDTH_S)]
    high = [math.inf, *2 * [math.log(10.0 * float(x[-1] - x[0]) + 1.0)]]

    def height(theta: Floats) -> float:
        return float(kernels.ex_gaussian(x, sd * theta[0], math.exp(theta[1]), math.exp(theta[2])))

    tops = []
    for fraction in (0.05, 0.5, 0.95):
        tau, sigma = sd * math.sqrt(fraction), sd * math.sqrt(1.0 - fraction)
        tops.append(climb(height, [(mean - tau) / sd, math.log(sigma), math.log(tau)], low, high))
    theta, total = max(tops, key=lambda top: top[1])
    return np.array([sd * theta[0], math.exp(theta[1]), math.exp(theta[2])]), total
