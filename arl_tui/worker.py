"""The learner's process: gets ready what a session needs, then plays it (`arl_tui.session_player`).

It is started with the `spawn` method before the app runs. Textual replaces the standard streams, after which
no process can be started.
"""

import contextlib
import faulthandler
import multiprocessing
import os
import signal
import tempfile
import traceback
from multiprocessing.connection import Connection
from pathlib import Path
from typing import TYPE_CHECKING

from arl_tui.ahead import Ahead, fill
from arl_tui.app.compile_order import is_compiled, session_order
from arl_tui.app.demo_participant import DemoParticipant
from arl_tui.app.link import Crashed, Ready, TriedOut, WorkerLine, WorkerLink
from arl_tui.games.registry import try_out
from arl_tui.session_player import SessionPlayer
from arl_tui.warm_up import warm_up
from core.numerics.clock import MonotonicClock
from core.plugins import GameError, plugin_of
from core.session.protocol import Protocol
from core.system.processes import leave_with
from core.system.temporary import prefix_of, remove_left_behind

if TYPE_CHECKING:
    from core.recording.joined import FinishedPart
    from core.session.resume import ResumedSession
    from core.session.session import Session

LAST_WORDS = 4000
"""Characters of a dead worker's error output that are shown."""


def start_worker(
    protocol: Protocol, root_seed: int, *, simulated: bool = False, kept: "FinishedPart | None" = None
) -> WorkerLink:
    """Start the learner's process; call this before the app runs.

    Args:
        protocol: what is to be played.
        root_seed: of the session.
        simulated: let a simulated participant press keys, too.
        kept: what the session had done before it broke off; the agent is rebuilt from it.
    """
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    remove_left_behind()
    handle, log_path = tempfile.mkstemp(prefix=prefix_of("worker"), suffix=".log")
    os.close(handle)
    process = context.Process(
        target=worker_main,
        args=(theirs, protocol, root_seed, simulated, log_path, os.getpid(), kept),
        daemon=True,
    )
    process.start()
    theirs.close()
    return WorkerLink(ours, process, lambda: _last_words(Path(log_path)))


def _last_words(log: Path) -> str:
    with contextlib.suppress(OSError):
        words = log.read_text(errors="replace")[-LAST_WORDS:]
        log.unlink()
        return words
    return ""


def worker_main(
    connection: Connection,
    protocol: Protocol,
    root_seed: int,
    simulated: bool,
    log_path: str,
    parent: int,
    kept: "FinishedPart | None" = None,
) -> None:
    """Run in the worker process until the session is over or the screen's process is gone."""
    _leave_the_terminal(log_path)
    leave_with(parent, started_by_main_thread=True)
    line = WorkerLine(connection)
    clock = MonotonicClock()
    from core.numerics.finite import DivergedError
    from core.recording.joined import ResumeError

    try:
        before_ns = clock.now_ns()
        # Here, not above: these compile, and the screen's process imports this module.
        from core.session.reach import reach_of
        from core.session.session import build_session

        if plugin_of(protocol).foreign:
            try_out(protocol)
            line.send(TriedOut())
        ahead = get_ready(protocol)
        session = build_session(protocol, root_seed)
        demo_participant = DemoParticipant(session, protocol, root_seed) if simulated else None
        reach = reach_of(protocol)
        resumed = None if kept is None else caught_up(session, kept)
        line.send(Ready(warm_up_ns=clock.now_ns() - before_ns, reach=reach.fraction, step_s=reach.step_s))
        player = SessionPlayer(line, protocol, clock, demo_participant, ahead)
        player.run(session if resumed is None else resumed)
    except (ResumeError, DivergedError) as error:  # they say what to do
        with contextlib.suppress(OSError):
            line.send(Crashed(error=str(error), trace=""))
    except GameError as error:  # so do these; a user's own function may have failed behind it
        with contextlib.suppress(OSError):
            line.send(Crashed(error=str(error), trace=traceback.format_exc() if error.__cause__ else ""))
    except (EOFError, BrokenPipeError, ConnectionResetError):
        return  # Nobody is looking any more.
    except Exception as error:  # noqa: BLE001 - whatever it was, the participant must be told
        with contextlib.suppress(OSError):
            line.send(Crashed(error=f"{type(error).__name__}: {error}", trace=traceback.format_exc()))


def caught_up(session: "Session", kept: "FinishedPart") -> "ResumedSession":
    """Return a session that has done again what was recorded of it.

    Raises:
        ResumeError: something comes out otherwise than recorded.
    """
    from core.session.resume import ResumedSession

    resumed = ResumedSession(session, kept)
    resumed.catch_up()
    return resumed


def _leave_the_terminal(log_path: str) -> None:
    """Ignore the terminal's Ctrl+C and write errors to a file: the screen belongs to the other process.

    Where the worker crashes in native code, Python writes to that file where it was.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    log = os.open(log_path, os.O_WRONLY | os.O_CREAT | os.O_APPEND)
    os.dup2(log, 1)
    os.dup2(log, 2)
    os.close(log)
    faulthandler.enable(2)


def get_ready(protocol: Protocol) -> Ahead | None:
    """Make everything run once that a session runs.

    Returns:
        The process that compiles what the session needs, while Python stands in for it; None where all of it
        is loaded.
    """
    from core.numerics.interpreting import CAN_INTERPRET, start_interpreting

    order = session_order(protocol)
    if is_compiled(order) or not CAN_INTERPRET:
        fill(order)
        return None
    start_interpreting()
    warm_up(protocol)
    return Ahead(order)
