"""A short session that is played before the first one: what is slow the first time is over before the first
game.
"""

from collections.abc import Iterable

import msgspec

from arl_tui.app.demo_participant import DemoParticipant
from arl_tui.games.registry import screens_of
from core.events import EpisodeStarted, FrameShown, Input, KeyPressed, StepTaken
from core.numerics.clock import NS_PER_S, ManualClock
from core.session.protocol import Protocol


class WarmUpParticipant:
    """A participant who has seen each step and praises it at once."""

    def __init__(self) -> None:
        self._inputs = 0

    def during(self, step: int) -> Iterable[Input]:
        """Return a frame and a press for each step (`core.session.rollout.FeedbackSource`)."""
        if step < 0:
            return []
        self._inputs += 1
        time_ns = self._inputs * NS_PER_S
        press = KeyPressed(
            press=self._inputs,
            time_ns=time_ns + 1,
            key="j",
            value=1.0,
            frame=step,
            step=step,
            verdict="accepted",
        )
        return [FrameShown(frame=step, step=step, flushed_ns=time_ns), press]


def warm_up(protocol: Protocol) -> None:
    """Run everything once that a session runs: what is slow the first time is over before the first game."""
    from core.session.session import build_session

    short = msgspec.structs.replace(
        protocol.session, episodes=2, unseen_before=1, unseen_between=1, watched_steps=2, unseen_steps=20
    )
    protocol = msgspec.structs.replace(protocol, session=short)
    session = build_session(protocol, root_seed=0)
    demo_participant, renderer = (
        DemoParticipant(session, protocol, root_seed=0),
        screens_of(protocol).renderer(protocol),
    )
    for output in session.run(WarmUpParticipant(), ManualClock()):
        match output:
            case EpisodeStarted():
                demo_participant.begin(output)
                renderer.begin(output)
            case StepTaken():
                demo_participant.watch(output, shown_ns=0, hidden_ns=1)
                renderer.act(output)
