"""`arl warm-up`: compile everything now that sessions and matches would compile when they are first
played.
"""

import time

import click

from arl_tui.ahead import Ahead, fill
from arl_tui.app.compile_order import Order, is_compiled, match_order, session_order
from arl_tui.command_line import say
from arl_tui.games.registry import BUILT_IN, screens_called
from core.plugins import plugin_called

LOOK_S = 0.2
"""How often the bar is drawn anew."""
STEPS = 200
"""Of a bar."""


def warm_up() -> None:
    """Compile the kernels of the program's own games, with a bar for each part of the work."""
    from core.keepaway.pitch import KeepawayConfig
    from core.numerics.interpreting import kernel_notes

    compiled = [name for name in BUILT_IN if plugin_called(name).kernels]
    orders = {plugin_called(name).title: session_order(screens_called(name).demo(None)) for name in compiled}
    orders["Watching Keepaway"] = match_order(KeepawayConfig())
    for name, order in orders.items():
        if is_compiled(order):
            say(f"{name}: compiled already.")
        else:
            _compile(name, order)
    for line in kernel_notes():
        say(f"Note: {line}", err=True)


def _compile(name: str, order: Order) -> None:
    from core.numerics.interpreting import CAN_INTERPRET, interpreting, progress

    if not CAN_INTERPRET:
        say(f"{name}: compiling ...")
        fill(order)
        return
    with interpreting():
        fill(order, noted=False)  # to know what is needed
    ahead = Ahead(order)
    try:
        with click.progressbar(length=STEPS, label=f"{name:17}") as bar:
            done = 0
            while not ahead.finished:
                now = round(progress().fraction * STEPS)
                bar.update(max(0, now - done))
                done = max(now, done)
                time.sleep(LOOK_S)
            bar.update(STEPS - done)
    finally:
        ahead.close()
    if ahead.failed:
        fill(order)  # here, so that what is wrong is told
