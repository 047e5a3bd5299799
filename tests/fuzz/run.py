"""Run fuzzers: `python -m tests.fuzz.run SECONDS [NAME ...]`; an input that breaks a reader is kept and
named."""

import contextlib
import hashlib
import random
import resource
import sys
import time
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

from tests.fuzz.targets import TARGETS, Target

LONGEST_S = 10.0
MOST_BYTES = 1 << 30


@dataclass
class Found:
    """What a run has found."""

    inputs: int = 0
    refused: int = 0
    slowest_s: float = 0.0
    grown_bytes: int = 0
    broken: Counter = field(default_factory=Counter)
    kept: list[Path] = field(default_factory=list)

    @property
    def sound(self) -> bool:
        return not self.broken and self.slowest_s < LONGEST_S and self.grown_bytes < MOST_BYTES

    def __str__(self) -> str:
        broken = "; ".join(f"{count} x {what}" for what, count in self.broken.most_common()) or "none"
        return (
            f"{self.inputs:,} inputs, {self.refused:,} refused, undocumented: {broken}; slowest "
            f"{self.slowest_s:.2f} s, "
            f"memory grew by {self.grown_bytes / 1e6:.0f} MB; kept: "
            f"{', '.join(map(str, self.kept)) or 'none'}"
        )


def fuzz(target: Target, *, seconds: float = 1e9, inputs: int = 1 << 60, root_seed: int = 0) -> Found:
    """Read inputs until the time or their number is over."""
    rng, found = random.Random(f"{target.name} {root_seed}"), Found()
    seeds = target.seeds()
    _warm_up(target, seeds[0])
    before, until = _memory(), time.perf_counter() + seconds
    while found.inputs < inputs and time.perf_counter() < until:
        made = target.make(rng.choice(seeds), seeds, rng)
        path = target.folder / f"input{target.suffix}"
        path.write_bytes(made)
        start = time.perf_counter()
        try:
            target.read(path)
        except target.documented:
            found.refused += 1
        except Exception as error:  # noqa: BLE001 - that is what is looked for
            _keep(target, made, error, found)
        found.slowest_s = max(found.slowest_s, time.perf_counter() - start)
        found.inputs += 1
    found.grown_bytes = _memory() - before
    return found


def _warm_up(target: Target, seed: bytes) -> None:
    """Read a sound input: what is compiled and imported the first time is not the input's fault."""
    path = target.folder / f"seed{target.suffix}"
    path.write_bytes(seed)
    with contextlib.suppress(*target.documented):
        target.read(path)


def _keep(target: Target, made: bytes, error: Exception, found: Found) -> None:
    trace = error.__traceback__
    while trace is not None and trace.tb_next is not None:
        trace = trace.tb_next
    where = "" if trace is None else f"{Path(trace.tb_frame.f_code.co_filename).name}:{trace.tb_lineno}"
    what = f"{type(error).__name__} at {where}"
    found.broken[what] += 1
    if found.broken[what] == 1:
        kept = target.folder / f"broken-{hashlib.sha256(made).hexdigest()[:8]}{target.suffix}"
        kept.write_bytes(made)
        found.kept.append(kept)


def _memory() -> int:
    used = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return used if sys.platform == "darwin" else used * 1024


if __name__ == "__main__":
    for name in sys.argv[2:] or TARGETS:
        print(f"{name}: {fuzz(TARGETS[name], seconds=float(sys.argv[1]), root_seed=1)}", flush=True)
