"""No child outlives a parent that is killed."""

import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tests.e2e.processes import descendants, is_running, left_after

PARENT = """
import os, sys, time
from studies.pools import processes

def busy():
    while True:
        pass

if __name__ == "__main__":
    with processes(2) as pool:
        print(pool.submit(os.getpid).result(), pool.submit(os.getpid).result(), flush=True)
        pool.submit(busy)
        pool.submit(busy)
        time.sleep(600)
"""


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM])
def test_a_killed_parent_leaves_no_processes_of_its_pool(number: signal.Signals, tmp_path: Path) -> None:
    script = tmp_path / "parent.py"
    script.write_text(PARENT)
    repository = Path(__file__).resolve().parents[3]
    parent = subprocess.Popen(
        [sys.executable, str(script)], stdout=subprocess.PIPE, env={"PYTHONPATH": str(repository)}
    )
    try:
        assert parent.stdout is not None
        parent.stdout.readline()
        family = descendants(parent.pid)
        assert sum(is_running(pid) for pid in family) >= 2
        parent.send_signal(number)
        parent.wait(10)
        assert left_after(family, 5.0) == set()
    finally:
        parent.kill()
        parent.wait()
        parent.stdout.close()
