"""Driving the app in tests: the worker's part, a running episode, and what was recorded."""

from collections.abc import Mapping
from pathlib import Path

from textual.pilot import Pilot
from textual.widgets import Static

from arl_tui.app.link import Picture, Ready
from arl_tui.app.outcome import SessionOutcome
from arl_tui.app.session_setup import SessionSetup
from arl_tui.games.tetris.renderer import TetrisRenderer
from arl_tui.session_app import ArlApp, build_app
from core.recording.reader import Recording, read_recording
from core.session.protocol import Protocol
from tests.arl_tui.fakes import FakeLink, episode_started, step_taken

SIZE = (80, 24)


def app_for(
    protocol: Protocol,
    link: FakeLink,
    recordings: Path,
    *,
    source: Mapping[str, str] | None = None,
    practice: bool = False,
) -> ArlApp:
    """Return the app before which P01 sits down."""
    setup = SessionSetup(
        protocol=protocol,
        root_seed=5,
        participant="P01",
        recordings=recordings,
        source=source or {},
        practice=practice,
    )
    return build_app(setup, link)


class Worker:
    """Plays the worker's part: outputs, and the pictures that go with them."""

    def __init__(self, link: FakeLink, protocol: Protocol) -> None:
        self.link = link
        self.renderer = TetrisRenderer(protocol.domain)
        self.pictures = 0

    def start_episode(self) -> None:
        started = episode_started()
        self.link.say(started)
        self.show(-1, self.renderer.begin(started)[0].view)

    def step(self, number: int, column: int = 0) -> None:
        taken = step_taken(number, column=column)
        self.link.say(taken)
        self.show(number, self.renderer.act(taken)[0].view)

    def show(self, step: int, view: object) -> None:
        self.link.say(Picture(number=self.pictures, step=step, view=view))  # type: ignore[arg-type]
        self.pictures += 1


async def begin(
    pilot: Pilot[SessionOutcome], link: FakeLink, protocol: Protocol, *, steps: int = 0
) -> Worker:
    """Bring the app to a running episode of which so many steps have been shown."""
    link.say(Ready(warm_up_ns=1))
    await pilot.press("enter")
    await pilot.pause()
    worker = Worker(link, protocol)
    worker.start_episode()
    await settle(pilot)
    for step in range(steps):
        worker.step(step)
        await settle(pilot)
    return worker


async def settle(pilot: Pilot[SessionOutcome]) -> None:
    """Wait until what has been said is drawn and stamped, and what is being saved is saved."""
    await pilot.pause(0.05)
    await pilot.app.workers.wait_for_complete()
    await pilot.pause()


def recorded(folder: Path) -> Recording:
    (path,) = folder.glob("*.jsonl")
    return read_recording(path)


def text_of(app: ArlApp) -> str:
    return "\n".join(str(widget.render()) for widget in app.screen.query(Static))
