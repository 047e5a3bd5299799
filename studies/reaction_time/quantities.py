"""What a gamma delay means: mean, mode, sd and quantiles in seconds, from shape, scale and offset."""

import numpy as np
from scipy import special

from core.numerics.arrays import Floats
from studies.reaction_time.families import GAMMA, SHIFTED_GAMMA, FamilyFit
from studies.reaction_time.family import Family

QUANTITIES = ("shape", "scale_s", "offset_s", "mean_s", "mode_s", "sd_s", "q05_s", "q50_s", "q95_s")
QUANTILES = {"q05_s": 0.05, "q50_s": 0.5, "q95_s": 0.95}


def gamma_quantities(
    shape: Floats | float, scale_s: Floats | float, offset_s: Floats | float
) -> dict[str, Floats]:
    """Return parameters and derived mean, mode, sd and quantiles (seconds), broadcast over the arguments."""
    k, scale, offset = np.broadcast_arrays(
        np.asarray(shape, np.float64), np.asarray(scale_s, np.float64), np.asarray(offset_s, np.float64)
    )
    result = {
        "shape": k,
        "scale_s": scale,
        "offset_s": offset,
        "mean_s": offset + k * scale,
        "mode_s": offset + np.maximum(k - 1.0, 0.0) * scale,
        "sd_s": np.sqrt(k) * scale,
    }
    for name, p in QUANTILES.items():
        result[name] = offset + scale * special.gammaincinv(k, p)
    return result


def quantities_of(fit: FamilyFit) -> dict[str, float]:
    """Return `gamma_quantities` of a gamma or shifted gamma fit as numbers."""
    p = fit.parameters
    found = gamma_quantities(p["shape"], p["scale_s"], p.get("offset_s", 0.0))
    return {name: float(value) for name, value in found.items()}


def require_gamma(family: Family) -> None:
    """Raise ValueError unless `family` is the gamma or the shifted gamma."""
    if family not in (GAMMA, SHIFTED_GAMMA):
        raise ValueError(f"intervals are computed for gamma and shifted gamma, not for {family.name!r}")
