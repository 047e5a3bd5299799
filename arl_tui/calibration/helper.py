"""Work for another process: a module of ours reads JSON from its standard input and writes JSON to its
output.
"""

import asyncio
import os
import runpy
import sys
from asyncio.subprocess import PIPE, Process
from contextlib import suppress

import msgspec

from core.system.processes import leave_with


class HelperError(RuntimeError):
    """The other process failed; the message ends with what it said last."""


async def ask_helper(module: str, question: object) -> bytes:
    """Run `module` on a question; the screen goes on meanwhile.

    Args:
        module: dotted name of a module with a `main`.
        question: anything that msgspec encodes.

    Returns:
        Its answer, JSON.

    Raises:
        HelperError: the process failed.
    """
    # All three streams are pipes: Textual has replaced the standard ones by objects without a file.
    process = await asyncio.create_subprocess_exec(
        sys.executable, "-m", __name__, module, str(os.getpid()), stdin=PIPE, stdout=PIPE, stderr=PIPE
    )
    try:
        answer, words = await process.communicate(msgspec.json.encode(question))
    except asyncio.CancelledError:
        process.kill()
        await _collect(process)
        raise
    if process.returncode:
        lines = words.decode(errors="replace").strip().splitlines() or ["no message"]
        raise HelperError(f"{module} left with status {process.returncode}: {lines[-1]}")
    return answer


async def _collect(process: Process) -> None:
    """Wait until a killed process and its pipes are gone.

    A loop that is about to close cancels every task, also one that was cancelled before: the wait goes on.
    """
    while True:
        with suppress(asyncio.CancelledError):
            await process.communicate()
            return


def main(module: str, parent: str) -> None:
    """Run a module in this process, which ends with its parent.

    Args:
        module: dotted name.
        parent: process id of the parent.
    """
    leave_with(int(parent), started_by_main_thread=True)
    runpy.run_module(module, run_name="__main__")


if __name__ == "__main__":
    main(*sys.argv[1:])
