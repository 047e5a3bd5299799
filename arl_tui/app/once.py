"""Calling back once, after a while: also on a machine that is too busy to look at the clock in time."""

import asyncio
from collections.abc import Callable

from textual.message_pump import MessagePump


def after(pump: MessagePump, delay_s: float, callback: Callable[[], object]) -> asyncio.TimerHandle:
    """Call back in `pump`'s own task after `delay_s` seconds; `cancel()` what is returned to take that back.

    In place of Textual's `set_timer`, whose timers skip what is late: one that is to ring once and is held up
    for longer than its delay between two looks at the clock, while it starts, never rings.
    """
    return asyncio.get_running_loop().call_later(delay_s, pump.call_next, callback)
