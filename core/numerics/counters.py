"""Random numbers by counter: draw k of a seed, without a state, the same compiled and in plain Python."""

from core.numerics.compiled import kernel

# Low 62 bits: products of such numbers, cut again, are the same in wrapping int64 and in Python's integers.
_MASK_62 = (1 << 62) - 1
_GOLDEN = 0x1E3779B97F4A7C15
_MIX_1 = 0x3F58476D1CE4E5B9
_MIX_2 = 0x14D049BB133111EB


@kernel
def uniform_at(seed: int, counter: int) -> float:
    """Return draw number `counter` of a seed, uniform in [0, 1).

    Args:
        seed: in [0, 2**62).
        counter: >= 0.
    """
    mixed = (int(seed) + (int(counter) + 1) * _GOLDEN) & _MASK_62
    mixed = ((mixed ^ (mixed >> 30)) * _MIX_1) & _MASK_62
    mixed = ((mixed ^ (mixed >> 27)) * _MIX_2) & _MASK_62
    mixed = mixed ^ (mixed >> 31)
    return (mixed >> 9) * (1.0 / (1 << 53))
