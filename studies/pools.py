"""Pools of processes on this machine, none of which outlives the process that made the pool."""

import os
import threading
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import get_context

from core.system.processes import leave_with


@contextmanager
def processes(workers: int) -> Iterator[ProcessPoolExecutor]:
    """Run calls in so many processes of this machine.

    The processes are started anew ("spawn"): the caller may have threads, which a fork would copy in mid-air.
    They end when the block is left; by an error without finishing what is waiting; and within a second when
    the caller is killed.

    Args:
        workers: >= 1.

    Submit calls in the thread that enters the block.
    """
    in_main_thread = threading.current_thread() is threading.main_thread()
    with ProcessPoolExecutor(
        workers,
        mp_context=get_context("spawn"),
        initializer=_begin,
        initargs=(os.getpid(), in_main_thread),
    ) as pool:
        try:
            yield pool
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def _begin(parent: int, in_main_thread: bool) -> None:
    leave_with(parent, started_by_main_thread=in_main_thread)
