"""Replay a folder of recordings, and draw how well each watched game went.

    python examples/replay_and_plot.py FOLDER FIGURE.png

Without arguments the program records a session with a simulated participant first.
"""

import sys
import tempfile
from pathlib import Path

from matplotlib.figure import Figure

from core import Protocol, SessionConfig, build_session, protocol_from, read_recording, replay_exactly
from core.events import EpisodeEnded
from studies.demo import simulate_session


def record_a_session(folder: Path) -> None:
    """Record a short session of Tetris with a simulated participant."""
    protocol = Protocol(session=SessionConfig(episodes=4, unseen_between=100, watched_steps=20))
    simulate_session(protocol, root_seed=1, target=folder / "simulated.jsonl", software={})


def performances(path: Path) -> list[float]:
    """Replay one recording exactly; return the performance of each watched game (Tetris: lines)."""
    recording = read_recording(path)
    session = build_session(protocol_from(recording.header.protocol), recording.header.root_seed)
    difference = replay_exactly(recording, session).difference
    print(f"{path.name}: {'replays exactly' if difference is None else f'differs: {difference}'}")
    return [event.performance for event in recording.outputs if isinstance(event, EpisodeEnded)]


def draw(curves: dict[str, list[float]], target: Path) -> None:
    """Draw one line per recording."""
    figure = Figure(figsize=(6, 3.5), layout="constrained")
    axes = figure.add_subplot(xlabel="watched game", ylabel="performance")
    for name, values in curves.items():
        axes.plot(range(1, len(values) + 1), values, marker="o", label=name)
    axes.legend()
    figure.savefig(target)


def main(folder: Path, target: Path) -> None:
    """Replay and draw everything in a folder."""
    draw({path.stem: performances(path) for path in sorted(folder.glob("*.jsonl"))}, target)
    print(f"Figure: {target}")


if __name__ == "__main__":
    if len(sys.argv) == 3:
        main(Path(sys.argv[1]), Path(sys.argv[2]))
    else:
        here = Path(tempfile.mkdtemp())
        record_a_session(here)
        main(here, here / "performance.png")
