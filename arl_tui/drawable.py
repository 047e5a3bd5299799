"""Whether the program was started where it can draw and read keys."""

import os
import sys


def why_not_drawable() -> str:
    """Return why nothing can be drawn here or no key be read, in words; "" where both are possible."""
    if not (sys.stdin.isatty() and sys.stdout.isatty()):
        return "needs a terminal to draw in and a keyboard"
    if os.environ.get("TERM") == "dumb":
        return (
            "needs a terminal to draw in, and this one cannot draw (TERM=dumb; consoles of editors say so): "
            "open a terminal window"
        )
    return ""
