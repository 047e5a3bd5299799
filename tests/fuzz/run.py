"""Run fuzzers: `python -m tests.fuzz.run SECONDS SEED [NAME ...]`; an input that breaks a reader, or takes it
long, is kept and named."""

import contextlib
import hashlib
import random
import resource
import shutil
import sys
import tempfile
import time
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

from tests.fuzz.targets import TARGETS, Target

LONGEST_S = 10.0
WORTH_KEEPING_S = 3.0
"""An input that takes longer is kept, the slowest of them."""
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
    folder = Path(tempfile.mkdtemp(prefix=f"arl-fuzz-{target.name}-"))
    seeds = target.seeds()
    _warm_up(target, seeds[0], folder)
    before, until = _memory(), time.perf_counter() + seconds
    while found.inputs < inputs and time.perf_counter() < until:
        made = target.make(rng.choice(seeds), seeds, rng)
        path = folder / f"input{target.suffix}"
        path.write_bytes(made)
        start = time.perf_counter()
        try:
            target.read(path)
        except target.documented:
            found.refused += 1
        except Exception as error:  # noqa: BLE001 - that is what is looked for
            _keep(path, made, error, found)
        _note_time(path, made, time.perf_counter() - start, found)
        found.inputs += 1
    found.grown_bytes = _memory() - before
    if not found.kept:
        shutil.rmtree(folder)
    return found


def _warm_up(target: Target, seed: bytes, folder: Path) -> None:
    """Read a sound input: what is compiled and imported the first time is not the input's fault."""
    path = folder / f"seed{target.suffix}"
    path.write_bytes(seed)
    with contextlib.suppress(*target.documented):
        target.read(path)


def _note_time(path: Path, made: bytes, took_s: float, found: Found) -> None:
    if took_s <= found.slowest_s:
        return
    found.slowest_s = took_s
    if took_s > WORTH_KEEPING_S:
        kept = path.with_name(f"slowest{path.suffix}")
        kept.write_bytes(made)
        found.kept = [*(each for each in found.kept if each != kept), kept]


def _keep(path: Path, made: bytes, error: Exception, found: Found) -> None:
    trace = error.__traceback__
    while trace is not None and trace.tb_next is not None:
        trace = trace.tb_next
    where = "" if trace is None else f"{Path(trace.tb_frame.f_code.co_filename).name}:{trace.tb_lineno}"
    what = f"{type(error).__name__} at {where}"
    found.broken[what] += 1
    if found.broken[what] == 1:
        kept = path.with_name(f"broken-{hashlib.sha256(made).hexdigest()[:8]}{path.suffix}")
        kept.write_bytes(made)
        found.kept.append(kept)


def _memory() -> int:
    used = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return used if sys.platform == "darwin" else used * 1024


if __name__ == "__main__":
    for name in sys.argv[3:] or TARGETS:
        came = fuzz(TARGETS[name], seconds=float(sys.argv[1]), root_seed=int(sys.argv[2]))
        print(f"{name}: {came}", flush=True)
