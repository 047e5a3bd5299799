"""An experiment whose trials are shared among the workers of a cluster; needs the extra `cluster`.

    python examples/experiment_on_a_cluster.py                       # two workers in this process
    python examples/experiment_on_a_cluster.py tcp://host:8786       # a Dask cluster that you trust

The same file also runs as `arl experiment run examples/experiment_on_a_cluster.py`.
"""

import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray

from core import AgentConfig, Protocol, SessionConfig, read_recording
from core.combination.config import EnvironmentOnly, Linear
from core.events import EpisodeEnded
from studies.demo import simulate_session
from studies.experiments.run import run_sweep
from studies.experiments.sweep import Condition, Experiment, load_experiment

SESSION = SessionConfig(episodes=4, unseen_between=50, watched_steps=20, unseen_steps=200)


def trial(settings: Protocol, root_seed: int) -> Mapping[str, NDArray[np.float64]]:
    """Play a session with a simulated participant; return the lines of each watched game."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "session.jsonl"
        simulate_session(settings, root_seed, path, software={})
        ended = [event for event in read_recording(path).outputs if isinstance(event, EpisodeEnded)]
    return {"lines": np.array([event.performance for event in ended])}


def quick(settings: Protocol) -> Protocol:
    """Return the settings of a trial of a second."""
    return msgspec.structs.replace(settings, session=msgspec.structs.replace(SESSION, episodes=2))


EXPERIMENT = Experiment(
    title="With and without a participant",
    conditions=(
        Condition(
            "alone",
            "environment alone",
            Protocol(session=SESSION, agent=AgentConfig(scheme=EnvironmentOnly())),
        ),
        Condition(
            "linear", "with presses (Eq. 3)", Protocol(session=SESSION, agent=AgentConfig(scheme=Linear()))
        ),
    ),
    trial=trial,
    quick=quick,
)


def main(address: str | None) -> None:
    """Play two trials of each condition on a cluster."""
    from distributed import Client, LocalCluster

    cluster = address or LocalCluster(
        n_workers=2, threads_per_worker=1, processes=False, dashboard_address=None
    )
    folder = Path(tempfile.mkdtemp())
    with Client(cluster) as client:
        files = run_sweep(load_experiment(__file__), range(2), folder, client.get_executor())
    if address is None:
        cluster.close()
    for path in sorted(files):
        lines = np.loadtxt(path, delimiter=",", skiprows=1, ndmin=1)
        print(f"{path.relative_to(folder)}: {lines.mean():.1f} lines per watched game")


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else None)
