"""Does pooling help? Fit a few trials of each person, then ask how well the fit foretells the others.

Two proper scores on trials the fit has not seen, both per trial: the log density (infinitely bad where a
response comes before a fitted offset) and the mean pinball loss over 19 quantiles (half the CRPS, in
milliseconds).
"""

from collections.abc import Mapping

import msgspec
import numpy as np
from scipy import special, stats

from core.numerics.arrays import Floats
from core.numerics.streams import stream
from studies.reaction_time.families import GAMMA, SHIFTED_GAMMA, fit_family
from studies.reaction_time.pooling import pool
from studies.reaction_time.sample import Sample, sample

Parameters = tuple[float, float, float]
LEVELS = np.arange(1, 20) / 20.0
METHODS = (
    "alone, gamma",
    "alone, shifted gamma",
    "everybody alike",
    "pooled, gamma",
    "pooled, shifted gamma",
)


class HeldOutScore(msgspec.Struct, frozen=True, kw_only=True):
    """One method's errors on trials it has not seen, averaged over people and splits."""

    method: str
    n_fitted: int
    """Trials per person that were fitted."""
    n_people: int
    log_density: float
    """Mean over people of the mean log density per held-out trial (per second); -inf if one person's is."""
    impossible: float
    """Fraction of people with a held-out response that the fit calls impossible."""
    pinball_ms: float
    """Mean pinball loss, milliseconds: lower is better."""
    better_than_alone: float
    """Fraction of people whose pinball loss is lower than with a gamma of their own."""
    pinball_gain_ms: float
    """Mean over people of (gamma alone - this method), milliseconds."""
    pinball_gain_se_ms: float
    """Standard error of that mean over people."""


def compare_held_out(
    times: Mapping[str, Floats], *, n_fitted: int, root_seed: int, n_splits: int = 3
) -> tuple[HeldOutScore, ...]:
    """Return every method's score.

    Args:
        times: participant to all reaction times, seconds; people with fewer than n_fitted + 5 are left out.
        n_fitted: trials per person drawn at random for the fit; the others are held out.
        root_seed: seed of the splits.
        n_splits: random splits; a person's scores are averaged over them.
    """
    people = {name: x for name, x in times.items() if x.size >= n_fitted + 5}
    if not people:
        raise ValueError(f"nobody has {n_fitted + 5} trials: fit fewer than {n_fitted} per person")
    density = np.zeros((len(METHODS), n_splits, len(people)))
    loss = np.zeros_like(density)
    for split in range(n_splits):
        rng = stream(root_seed, "held-out trials", split)
        orders = {name: rng.permutation(x) for name, x in people.items()}
        fitted = {name: sample(x[:n_fitted]) for name, x in orders.items()}
        for m, parameters in enumerate(_estimates(fitted)):
            for i, (name, order) in enumerate(orders.items()):
                density[m, split, i] = _log_density(parameters[name], order[n_fitted:])
                loss[m, split, i] = pinball_loss(parameters[name], order[n_fitted:])
    by_person = loss.mean(axis=1) * 1e3
    gains = by_person[0] - by_person
    return tuple(
        HeldOutScore(
            method=method,
            n_fitted=n_fitted,
            n_people=len(people),
            log_density=float(density[m].mean()),
            impossible=float(np.isneginf(density[m]).mean()),
            pinball_ms=float(by_person[m].mean()),
            better_than_alone=float((gains[m] > 0.0).mean()),
            pinball_gain_ms=float(gains[m].mean()),
            pinball_gain_se_ms=float(gains[m].std(ddof=1) / np.sqrt(len(people))),
        )
        for m, method in enumerate(METHODS)
    )


def markdown_table(scores: tuple[HeldOutScore, ...]) -> str:
    """Return the scores as a table in Markdown."""
    lines = [
        (
            "| method | log density per trial | people with an impossible trial | pinball loss, ms | gain over "  # noqa: E501
            "alone, ms (se) | people better off |"
        ),
        "|---|---|---|---|---|---|",
    ]
    for s in scores:
        density = f"{s.log_density:.3f}" if np.isfinite(s.log_density) else "-inf"
        lines.append(
            f"| {s.method} | {density} | {s.impossible:.1%} | {s.pinball_ms:.3f} | "
            f"{s.pinball_gain_ms:+.3f} ({s.pinball_gain_se_ms:.3f}) | {s.better_than_alone:.0%} |"
        )
    return "\n".join(lines) + "\n"


def pinball_loss(parameters: Parameters, held_out: Floats) -> float:
    """Mean pinball loss of a gamma's quantiles at `LEVELS` on held-out times, seconds."""
    shape, scale, offset = parameters
    quantiles = offset + scale * special.gammaincinv(shape, LEVELS)
    above = held_out[:, None] - quantiles[None, :]
    return float(np.maximum(LEVELS * above, (LEVELS - 1.0) * above).mean())


def _log_density(parameters: Parameters, held_out: Floats) -> float:
    shape, scale, offset = parameters
    return float(stats.gamma.logpdf(held_out, shape, loc=offset, scale=scale).mean())


def _estimates(fitted: Mapping[str, Sample]) -> list[dict[str, Parameters]]:
    """Return participant to (shape, scale, offset) for each of `METHODS`."""
    alone = {name: fit_family(GAMMA, one).parameters for name, one in fitted.items()}
    shifted = {name: fit_family(SHIFTED_GAMMA, one).parameters for name, one in fitted.items()}
    together = fit_family(
        GAMMA, sample(np.concatenate([one.observed_s for one in fitted.values()]))
    ).parameters
    _, two = pool(fitted)
    _, three = pool(fitted, shifted=True)
    return [
        {name: (p["shape"], p["scale_s"], 0.0) for name, p in alone.items()},
        {name: (p["shape"], p["scale_s"], p["offset_s"]) for name, p in shifted.items()},
        dict.fromkeys(fitted, (together["shape"], together["scale_s"], 0.0)),
        {name: (p.shape, p.scale_s, p.offset_s) for name, p in two.items()},
        {name: (p.shape, p.scale_s, p.offset_s) for name, p in three.items()},
    ]
