"""The process that prepares a game while pages are read."""

import asyncio
import gc
import os

import pytest

from arl_tui.calibration.helper import ask_helper
from tests.e2e.processes import children, left_after


def test_who_leaves_while_a_game_is_prepared_leaves_no_process_and_no_message(
    capfd: pytest.CaptureFixture[str],
) -> None:
    before = children(os.getpid())
    started: set[int] = set()

    async def leave() -> None:
        asked = asyncio.ensure_future(ask_helper("timeit", None))
        while not (begun := children(os.getpid()) - before):
            await asyncio.sleep(0.01)
        started.update(begun)
        await asyncio.sleep(0.05)
        asked.cancel()
        for _ in range(6):  # It hears of it, and kills the process.
            await asyncio.sleep(0)
        # The loop that closes now cancels it once more.

    asyncio.run(leave())
    gc.collect()
    assert left_after(started, 5.0) == set()
    assert capfd.readouterr().err == ""
