"""What is to be compiled before a session or a match can be played fast, and whether it has been."""

import msgspec

from core.keepaway.pitch import KeepawayConfig
from core.numerics.kernel_folder import is_ready
from core.recording.schema import to_plain
from core.session.protocol import Protocol


class Order(msgspec.Struct, frozen=True, kw_only=True):
    """What is to be compiled: everything that a session needs, or that watching a match needs."""

    protocol: dict[str, object] | None = None
    """Of the session, as `core.recording.schema.to_plain` writes it."""
    task: KeepawayConfig | None = None
    """Of the match."""


def session_order(protocol: Protocol) -> Order:
    """Return the order for a session."""
    return Order(protocol=to_plain(protocol))


def match_order(task: KeepawayConfig) -> Order:
    """Return the order for watching matches."""
    return Order(task=task)


DECIDE = ("domain", "learner", "agent", "trainer", "others")
"""Tables of a protocol that decide about what is compiled."""


def purpose_of(order: Order) -> str:
    """Return an order's name in the notes on what has been compiled."""
    protocol = order.protocol and {name: order.protocol.get(name) for name in DECIDE}
    return msgspec.json.encode(Order(protocol=protocol, task=order.task)).decode()


def is_compiled(order: Order) -> bool:
    """Return whether everything that an order asks for has been compiled before."""
    return is_ready(purpose_of(order))
