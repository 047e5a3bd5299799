"""Practice of a session's task: games that are recorded and do not count."""

import msgspec

from core.feedback.delays import GammaDelay
from core.session.protocol import Protocol

PRACTICE_SLOWER = 1.5
"""A practice game is so many times slower than a session's."""
PRACTICE_GAMES = 2
"""How many games a practice has at most."""


def practice_of(protocol: Protocol, *, games: int = PRACTICE_GAMES, name: str | None = None) -> Protocol:
    """Return the protocol of a practice: slow, nothing unseen, no wrong presses, each press is marked.

    Args:
        protocol: of the session that comes after.
        games: how many at most, >= 1; it ends before when both keys have been pressed in time.
        name: of the practice; None: that of the protocol.
    """
    session = msgspec.structs.replace(protocol.session, episodes=games, unseen_before=0, unseen_between=0)
    screen = protocol.screen
    screen = msgspec.structs.replace(
        screen,
        tick_ms=min(2000, round(screen.tick_ms * PRACTICE_SLOWER)),
        speed=max(0.05, screen.speed / PRACTICE_SLOWER),
        mark_presses=True,
    )
    keys = msgspec.structs.replace(protocol.keys, wrong_press_rate=0.0)
    if protocol.delay_of != "rule":  # nobody is calibrated yet
        credit = msgspec.structs.replace(protocol.agent.credit, delay=GammaDelay())
        agent = msgspec.structs.replace(protocol.agent, credit=credit)
        protocol = msgspec.structs.replace(protocol, agent=agent, delay_of="rule")
    return msgspec.structs.replace(
        protocol, name=name or protocol.name, session=session, screen=screen, keys=keys
    )
