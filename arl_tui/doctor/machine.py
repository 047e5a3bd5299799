"""Checks that need no terminal: versions, system, clock, sleeps, processors, compiled code, folders and
disk.
"""

import os
import platform
import shutil
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from arl_tui.app import facts
from arl_tui.doctor.findings import Finding
from arl_tui.home import home, why_here
from arl_tui.settings import NAME, read_settings, settings_file

OLDEST, NEWEST = (3, 11), (3, 14)
"""Versions of Python for which all libraries have ready-made packages; as in pyproject.toml."""
COARSE_NS = 1_000_000
"""A clock with larger steps is too coarse for reaction times."""
BUSY = 0.5
"""Load per processor above which timing suffers (as `arl timing`)."""
LITTLE_MB, ENOUGH_MB = 50, 500
"""Free space below which no session starts well, and below which it is worth a word."""
SLOW_SYNC_S = 0.15
"""A write that takes longer makes the screen say "saving ..."."""


def machine_findings(recordings: Path) -> Iterator[Finding]:
    """Yield what was found on this machine.

    Args:
        recordings: the folder where sessions would be kept; it need not exist.
    """
    yield python_finding(sys.version_info[:2])
    yield Finding("libraries", ", ".join(f"{name} {version}" for name, version in facts.software().items()))
    yield system_finding(platform.system())
    yield clock_finding()
    yield sleep_finding()
    yield load_finding(os.cpu_count() or 1, os.getloadavg()[0] if hasattr(os, "getloadavg") else 0.0)
    yield compiled_finding()
    yield Finding("home", why_here(), private=str(home()))
    yield settings_finding(settings_file())
    yield from disk_findings(recordings)


def python_finding(version: tuple[int, int]) -> Finding:
    """Return whether this Python is one that all libraries support."""
    found = f"Python {platform.python_version()}"
    if OLDEST <= version <= NEWEST:
        return Finding("python", found)
    wanted = f"{OLDEST[0]}.{OLDEST[1]} to {NEWEST[0]}.{NEWEST[1]}"
    return Finding("python", found, "stop", f"install Python {wanted}: numba supports no other")


def system_finding(system: str) -> Finding:
    """Return whether sessions run on this system."""
    found = f"{system} {platform.release()}, {platform.machine()}"
    if system in ("Linux", "Darwin"):
        return Finding("system", found)
    return Finding(
        "system",
        found,
        "stop",
        "use Linux or macOS; on Windows, WSL (https://learn.microsoft.com/windows/wsl)",
    )


def clock_finding() -> Finding:
    """Return whether the clock of all times is fine enough, by its own word and by looking."""
    name, resolution_ns = facts.clock_facts()
    steps = set()
    last = time.monotonic_ns()
    for _ in range(10_000):
        now = time.monotonic_ns()
        if now > last:
            steps.add(now - last)
        last = now
    finest = min(steps, default=resolution_ns)
    found = f"{name}, resolution {resolution_ns} ns, smallest step seen {finest} ns"
    if finest < COARSE_NS:
        return Finding("clock", found)
    return Finding(
        "clock", found, "stop", "use a machine with a clock finer than a millisecond", ("calibration",)
    )


def sleep_finding() -> Finding:
    """Return how late plain sleeps end: what no program on this machine can do better than."""
    from arl_tui.timing.result import summarise
    from arl_tui.timing.waking import QUIET_P95_MS, lateness_ms

    late = summarise(lateness_ms())
    assert late is not None, "some sleeps have been measured"
    found = f"sleeps of 5 ms end {late.median:.2f} ms late (95 %: {late.p95:.2f} ms)"
    if late.p95 <= QUIET_P95_MS:
        return Finding("waking", found)
    return Finding(
        "waking",
        found,
        "beware",
        "close other programs, or use a machine of its own: times spread by so much",
    )


def load_finding(cores: int, load: float) -> Finding:
    """Return whether there are processors enough, and free ones."""
    found = f"{cores} processors, load {load:.1f}"
    if cores < 2:
        return Finding("processors", found, "beware", "use two or more: screen and learner are two processes")
    if load > BUSY * cores:
        return Finding(
            "processors", found, "beware", "wait until the machine is quiet, above all before a calibration"
        )
    return Finding("processors", found)


def compiled_finding() -> Finding:
    """Return whether compiled code can be kept, and whether there is any."""
    from core.numerics import kernel_folder
    from core.numerics.kernel_files import SUFFIX

    folder, _ = kernel_folder.cache_folder(kernel_folder.sources_digest())
    kept = sum(1 for _ in folder.glob(f"*{SUFFIX}"))
    there = next(above for above in (folder, *folder.parents) if above.exists())
    if kernel_folder.JIT_DISABLED:
        return Finding(
            "compiled code",
            "switched off by NUMBA_DISABLE_JIT",
            "beware",
            "unset it: sessions are many times slower",
        )
    if not (there.is_dir() and os.access(there, os.W_OK | os.X_OK)):
        return Finding(
            "compiled code",
            "cannot be kept: its folder is not writable",
            "beware",
            "set XDG_CACHE_HOME to a folder of your own; otherwise each start compiles anew",
            private=str(folder),
        )
    if not kept:
        return Finding(
            "compiled code",
            "none yet",
            "beware",
            "run `arl warm-up` once before the first participant: compiling takes a minute",
            private=str(folder),
        )
    return Finding("compiled code", f"{kept} kernels", private=str(folder))


def settings_finding(path: Path) -> Finding:
    """Return whether the settings of this computer can be read: nothing begins with settings that cannot.

    Args:
        path: of the file; it need not exist.
    """
    try:
        read_settings(path)
    except (ValueError, OSError) as error:
        todo = f"mend or remove {NAME}: no session begins; docs/how-to/language-and-keys.md has its keys"
        return Finding("settings", f"{NAME} cannot be used", "stop", todo, private=f"({error})")
    return Finding("settings", f"{NAME} can be used" if path.exists() else f"no {NAME}: as they come")


def disk_findings(recordings: Path) -> Iterator[Finding]:
    """Yield whether recordings can be written, how much room there is, and how fast a press gets to the
    disk.
    """
    there = next(folder for folder in (recordings, *recordings.absolute().parents) if folder.exists())
    if not (there.is_dir() and os.access(there, os.W_OK | os.X_OK)):
        yield Finding(
            "recordings",
            "the folder cannot be written to",
            "stop",
            "choose another with --recordings, or make it writable",
            private=str(recordings),
        )
        return
    new = "" if recordings.exists() else "; made at the first session"
    yield Finding("recordings", f"can be written{new}", private=str(recordings))
    free_mb = shutil.disk_usage(there).free // 1_000_000
    if free_mb < LITTLE_MB:
        yield Finding("disk", f"{free_mb} MB free", "stop", "make room: a session needs up to 10 MB")
    elif free_mb < ENOUGH_MB:
        yield Finding("disk", f"{free_mb} MB free", "beware", "make room before a study")
    else:
        yield Finding("disk", f"{free_mb / 1000:.1f} GB free")
    yield sync_finding(there)


def sync_finding(folder: Path) -> Finding:
    """Return how long the disk takes to confirm a line; the median of five."""
    taken = []
    try:
        with tempfile.TemporaryFile(dir=folder) as file:
            for _ in range(5):
                began_ns = time.monotonic_ns()
                file.write(b"x" * 300 + b"\n")
                file.flush()
                os.fsync(file.fileno())
                taken.append((time.monotonic_ns() - began_ns) / 1e9)
    except OSError as error:
        return Finding("write", f"fails: {error.strerror}", "stop", "choose another folder with --recordings")
    middle_s = sorted(taken)[2]
    found = f"a line is on the disk after {middle_s * 1000:.1f} ms"
    if middle_s <= SLOW_SYNC_S:
        return Finding("write", found)
    return Finding("write", found, "beware", "use a local disk: the screen will often say that it is saving")
