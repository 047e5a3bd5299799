"""Named random streams from one root seed.

Each purpose has a stream of its own, so a draw added to one never shifts another: every condition of an
experiment meets the same pieces, and trials pair by seed.
"""

import zlib
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    # At run time only where a stream is opened: a protocol is read without arrays.
    import numpy as np


def stream(root_seed: int, *path: str | int) -> "np.random.Generator":
    """Return the Generator named by `path`.

    Args:
        root_seed: seed of the session or experiment, >= 0.
        path: names and indices, outermost first, e.g. ``("trial", 3, "noise")``. At least one.

    Returns:
        A PCG64DXSM Generator; equal arguments give equal streams, on any machine and in any process.
    """
    import numpy as np

    return np.random.Generator(np.random.PCG64DXSM(np.random.SeedSequence(root_seed, spawn_key=_key(path))))


def resumed(state: Mapping[str, Any]) -> "np.random.Generator":
    """Return a Generator that goes on where a stream stood.

    Args:
        state: of its bit generator (`rng.bit_generator.state`).
    """
    import numpy as np

    rng = np.random.Generator(np.random.PCG64DXSM(0))
    rng.bit_generator.state = state
    return rng


def stream_seed(root_seed: int, *path: str | int) -> int:
    """Return a 63-bit seed for a counter-based stream (see `core.tetris.pieces`)."""
    import numpy as np

    state = np.random.SeedSequence(root_seed, spawn_key=_key(path)).generate_state(1, np.uint64)
    return int(state[0]) >> 1


def _key(path: tuple[str | int, ...]) -> tuple[int, ...]:
    if not path:
        raise ValueError("a stream needs a name: stream(seed, 'pieces'), not stream(seed)")
    key: list[int] = []
    for part in path:
        if isinstance(part, str):
            # The leading 1 keeps the name "x" apart from every index.
            key += [1, zlib.crc32(part.encode())]
        elif part >= 0:
            key += [0, int(part)]
        else:
            raise ValueError(f"an index in a stream's path is >= 0, got {part} in {path}")
    return tuple(key)
