"""The terminal app: shows and asks, never computes. Users run the command `arl`; of its modules nothing is
public.
"""

from typing import Any

__all__ = ["__version__"]


def __getattr__(name: str) -> Any:
    if name != "__version__":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib.metadata import version  # a tenth of a second, which `arl --help` need not wait for

    return version("arl-tui")
