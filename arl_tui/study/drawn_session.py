"""A simulated participant's session on the real screens, picture by picture, in time that passes at once.

The app, the recorder and the learner's side are those of a live session. Only three things differ: the event
loop's time moves on where it would sleep, the learner plays in a thread, and the header says that the session
is simulated.
"""

import asyncio
import contextvars
import threading
from collections.abc import Callable, Mapping
from pathlib import Path

import msgspec
from textual.pilot import Pilot

from arl_tui.app.demo_participant import DemoParticipant
from arl_tui.app.link import FromWorker, Ready, ToWorker, from_worker
from arl_tui.app.outcome import SessionOutcome
from arl_tui.app.session_setup import SessionSetup
from arl_tui.app.virtual_time import LoopClock, VirtualLoop, textual_in
from arl_tui.screens.welcome import WelcomeScreen
from arl_tui.session_app import ArlApp
from arl_tui.session_player import SessionPlayer
from core.recording.schema import Header
from core.session.protocol import Protocol

SIZE = (80, 24)
LOOK_S = 0.1
"""How often the simulated participant looks which page is shown, seconds of the loop's time."""


class DrawnSessionError(RuntimeError):
    """A screen or the learner failed: a session with a participant would fail as well."""


def draw_session(
    protocol: Protocol,
    root_seed: int,
    folder: Path,
    *,
    participant: str,
    source: Mapping[str, str],
    study: Mapping[str, str],
    practice: bool = False,
) -> SessionOutcome:
    """Send a simulated participant through a session's screens, headless, and record it.

    Args:
        protocol: of the session; `protocol.trainer` is the participant.
        root_seed: of the session.
        folder: of the recording.
        participant: code for the header.
        source: where the credit rule comes from, for the header.
        study: where the session belongs in a study, for the header.
        practice: nothing counts.

    Raises:
        DrawnSessionError: the session did not end as planned.
    """
    loop = VirtualLoop()
    link = _ThreadLink(loop, protocol, root_seed)
    setup = SessionSetup(
        protocol=protocol,
        root_seed=root_seed,
        participant=participant,
        recordings=folder,
        simulated=True,
        source=source,
        study=study,
        practice=practice,
    )
    app = _SimulatedApp(setup, link, loop)

    async def use(pilot: Pilot[object]) -> None:
        """Press Enter on the first page, and on the last."""
        while app.is_running:
            done = app.live.phase == "over" and app.screen is not app.play
            if done or (isinstance(app.screen, WelcomeScreen) and app.live.ready):
                await pilot.press("enter")
            await asyncio.sleep(LOOK_S)

    with textual_in(loop):
        outcome = app.run(headless=True, size=SIZE, auto_pilot=use, loop=loop)
    loop.close()
    if outcome is None or outcome.recording is None or outcome.trouble is not None:
        trouble = "the app ended without a result" if outcome is None else outcome.trouble
        raise DrawnSessionError(f"a simulated session of {participant} failed on the screens: {trouble}")
    return outcome


class _SimulatedApp(ArlApp):
    """The session's app; what it records says that it is simulated."""

    CSS_PATH = "../app.tcss"

    def __init__(self, setup: SessionSetup, link: "_ThreadLink", loop: VirtualLoop) -> None:
        super().__init__(setup, link, clock=LoopClock(loop))
        self._virtual_loop = loop

    async def _close_up(self, trouble: str | None) -> None:
        """Let no time pass while the disk works: the recorder gives it seconds of this clock."""
        self._virtual_loop.hold()
        try:
            await super()._close_up(trouble)
        finally:
            self._virtual_loop.go_on()

    def _header(self, created_utc: str) -> Header:
        return msgspec.structs.replace(
            super()._header(created_utc), origin="simulated", clock="simulated", clock_resolution_ns=1000
        )

    def _press_simulated(self, key: str) -> None:
        """Press a key; the wrong one where the screen has asked for it."""
        keys = self.setup.protocol.keys
        if self.live.gate.wrong_asked:
            key = keys.bad if key == keys.good else keys.good
        super()._press_simulated(key)


class _ThreadLink:
    """A session's player in a thread: the screen's end of the link, and the player's."""

    def __init__(self, loop: VirtualLoop, protocol: Protocol, root_seed: int) -> None:
        self._loop = loop
        self._protocol = protocol
        self._root_seed = root_seed
        self._inbox: asyncio.Queue[ToWorker] = asyncio.Queue()
        self._on_message: Callable[[FromWorker], None] = lambda _message: None
        self._on_lost: Callable[[str], None] = lambda _reason: None
        self._listening = False
        self._closed = False
        self._context = contextvars.copy_context()
        """The app's: a page that a message opens finds the app in it."""

    # --- the screen's end -----------------------------------------------------------------------------------

    def listen(self, on_message: Callable[[FromWorker], None], on_lost: Callable[[str], None]) -> None:
        """Start the player."""
        self._on_message, self._on_lost = on_message, on_lost
        self._listening = True
        self._context = contextvars.copy_context()
        self._loop.hold()
        threading.Thread(target=self._play, name="player", daemon=True).start()

    def stop_listening(self) -> None:
        """Deliver nothing more."""
        self._listening = False

    def send(self, message: ToWorker) -> None:
        """Put a message before the player."""
        self._inbox.put_nowait(message)

    def close(self, patience_s: float = 2.0) -> None:
        """The player ends by itself at its next look."""
        self._closed = True

    # --- the player's end, in its thread --------------------------------------------------------------------

    def _play(self) -> None:
        from core.session.reach import reach_of
        from core.session.session import build_session

        try:
            session = build_session(self._protocol, self._root_seed)
            participant = DemoParticipant(session, self._protocol, self._root_seed)
            reach = reach_of(self._protocol)
            line = _Line(self)
            line.send(Ready(warm_up_ns=0, reach=reach.fraction, step_s=reach.step_s))
            SessionPlayer(line, self._protocol, LoopClock(self._loop), participant).run(session)
        except EOFError:
            pass
        except Exception as error:  # noqa: BLE001 - whatever it was, the session must end
            reason = f"{type(error).__name__}: {error}"
            self.soon(self._lose, reason)
        self._loop.call_soon_threadsafe(self._loop.go_on)

    def soon(self, callback: Callable[..., None], argument: object) -> None:
        """Call back in the loop's thread, from the player's."""
        self._loop.call_soon_threadsafe(callback, argument, context=self._context.copy())

    def _lose(self, reason: str) -> None:
        if self._listening:
            self._on_lost(reason)

    def deliver(self, message: bytes) -> None:
        """Give a message of the player to the app. In the loop's thread."""
        if self._listening:
            self._on_message(from_worker(message))

    async def wait(self, timeout_s: float | None) -> list[ToWorker]:
        """Return the messages that are there, or the first within `timeout_s`. In the loop's thread."""
        self._loop.go_on()
        messages: list[ToWorker] = []
        try:
            if timeout_s is None or timeout_s > 0:
                async with asyncio.timeout(timeout_s):
                    messages.append(await self._inbox.get())
        except TimeoutError:
            pass
        while not self._inbox.empty():
            messages.append(self._inbox.get_nowait())
        self._loop.hold()
        return messages


class _Line:
    """What a player says and hears, as `arl_tui.app.link.WorkerLine`."""

    def __init__(self, link: _ThreadLink) -> None:
        self._link = link

    def send(self, message: FromWorker) -> None:
        """Say something to the app."""
        self._link.soon(self._link.deliver, msgspec.msgpack.encode(message))

    def receive(self, timeout_s: float | None = 0.0) -> list[ToWorker]:
        """Wait on the loop's time.

        Raises:
            EOFError: the app is gone.
        """
        if self._link._closed:
            raise EOFError
        waiting = asyncio.run_coroutine_threadsafe(self._link.wait(timeout_s), self._link._loop)
        try:
            return waiting.result()
        except asyncio.CancelledError:
            raise EOFError from None
