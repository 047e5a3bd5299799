"""The screen's end of the pipe, with a process that is only pretended."""

import asyncio
import multiprocessing
import os
from multiprocessing.connection import Connection

import msgspec
import pytest

from arl_tui.app.link import Begin, FromWorker, Ready, WorkerLine, WorkerLink
from core.events import FrameShown, KeyPressed


class PretendedProcess:
    """A worker that is asked how it ended."""

    def __init__(self, exitcode: int | None) -> None:
        self.exitcode = exitcode
        self.killed = False

    def join(self, timeout_s: float | None = None) -> None:
        """Return at once."""

    def is_alive(self) -> bool:
        return self.exitcode is None and not self.killed

    def kill(self) -> None:
        self.killed = True


class Bench:
    def __init__(self, *, exitcode: int | None = 0, words: str = "") -> None:
        ours, self.theirs = multiprocessing.Pipe()
        self.process = PretendedProcess(exitcode)
        self.link = WorkerLink(ours, self.process, lambda: words)  # type: ignore[arg-type]
        self.heard: list[FromWorker] = []
        self.lost: list[str] = []

    def listen(self) -> None:
        self.link.listen(self.heard.append, self.lost.append)


async def until(condition: object) -> None:
    for _ in range(6000):
        if condition():  # type: ignore[operator]
            return
        await asyncio.sleep(0.01)
    raise AssertionError("it did not come within a minute")


async def test_messages_arrive_in_order() -> None:
    bench = Bench()
    bench.listen()
    line = WorkerLine(bench.theirs)
    for number in range(100):
        line.send(Ready(warm_up_ns=number))
    await until(lambda: len(bench.heard) == 100)
    assert bench.heard == [Ready(warm_up_ns=number) for number in range(100)]
    bench.link.stop_listening()
    bench.link.close()


@pytest.mark.parametrize(
    ("exitcode", "how"), [(-9, "ended by signal 9"), (3, "left with status 3"), (None, "closed its end")]
)
async def test_the_end_of_the_worker_is_told_once_with_its_last_words(exitcode: int | None, how: str) -> None:
    bench = Bench(exitcode=exitcode, words="Fatal: out of memory\n")
    bench.listen()
    bench.theirs.close()
    await until(lambda: bench.lost)
    (reason,) = bench.lost
    assert how in reason
    assert "out of memory" in reason
    bench.link.close()
    assert len(bench.lost) == 1


async def test_what_was_said_before_the_end_is_heard_first() -> None:
    bench = Bench()
    WorkerLine(bench.theirs).send(Ready(warm_up_ns=1))
    bench.theirs.close()
    bench.listen()
    await until(lambda: bench.lost)
    assert bench.heard == [Ready(warm_up_ns=1)]
    bench.link.close()


async def test_nonsense_ends_the_session_with_a_reason() -> None:
    bench = Bench()
    bench.listen()
    bench.theirs.send_bytes(msgspec.msgpack.encode({"type": "ready", "warm_up_ns": "soon"}))
    await until(lambda: bench.lost)
    assert "cannot be understood" in bench.lost[0]
    bench.link.close()


def fill(connection: Connection) -> None:
    """Write to a pipe until it takes no more."""
    os.set_blocking(connection.fileno(), False)
    try:
        while True:
            os.write(connection.fileno(), b"\0" * 4096)
    except BlockingIOError:
        os.set_blocking(connection.fileno(), True)


async def test_sending_never_waits_for_a_worker_that_does_not_read() -> None:
    ours, theirs = multiprocessing.Pipe()
    fill(ours)
    process = PretendedProcess(None)
    link = WorkerLink(ours, process, str)  # type: ignore[arg-type]
    for number in range(2_000):
        link.send(FrameShown(frame=number, step=0, flushed_ns=0))
    # Getting here is the proof: a send that waited would wait for ever.
    link.close(patience_s=0.01)
    assert process.killed
    theirs.close()


async def test_messages_to_the_worker_keep_their_order() -> None:
    bench = Bench()
    press = KeyPressed(press=0, time_ns=1, key="j", value=1.0, frame=0, step=0, verdict="accepted")
    messages = [Begin(), press, FrameShown(frame=1, step=0, flushed_ns=2)]
    for message in messages:
        bench.link.send(message)
    line, received = WorkerLine(bench.theirs), []
    while len(received) < 3:
        received += line.receive(1.0)
    assert received == messages
    bench.link.close()
