"""Keepaway as it is watched in the feedback-lag task: a possession per trial that ends in a marked event.

Keepers with the hand-coded policy play. A trial shows the cycles before an event as they were played, then
the event itself within one picture: a pass reaches the keeper it was meant for (the ball is kept), or the
episode ends because a taker has the ball or it is out (lost). The mark tells that now is to be judged, not
what. Runs in a process of its own, because the match needs compiled code.
"""

import sys
from collections import deque
from collections.abc import Iterator

import msgspec

from arl_tui.language import later
from core.keepaway.picture import PitchFrame
from core.keepaway.pitch import CYCLE_S, NO_PLAYER, ONGOING, KeepawayConfig
from core.keepaway.plugin import KEEPAWAY
from core.numerics.streams import stream, stream_seed
from studies.reaction_time.protocol import Schedule

MARK = later("NOW")
"""Short: it has to fit beside the longest words about an event in the smallest pitch."""
LONGEST_S = 99.0
"""Later events are not taken: the time in their words would leave no room for the mark."""
MOST_EPISODES = 20_000
"""Looking through more of them than this for possessions that are long enough means that there are none."""
KEPT, LOST = "ball kept", "ball lost"


def cycle_ms(schedule: Schedule) -> float:
    """Return how long a cycle is shown: the session's pace."""
    return schedule.config.picture_ms or 1000.0 * CYCLE_S / KEEPAWAY.screen.speed


class Clip(msgspec.Struct, frozen=True, kw_only=True):
    """One trial's game."""

    before: tuple[PitchFrame, ...]
    """A picture per tick, up to the last one before the event."""
    event: PitchFrame
    note: str
    """What was shown, for the recording."""

    def at(self, tick: int) -> PitchFrame:
        """Return the picture of a tick; the last one before the event stays."""
        return self.before[min(tick, len(self.before) - 1)]


def judged(before: PitchFrame, now: PitchFrame) -> str | None:
    """Return what happens between two pictures: "ball kept", "ball lost", or nothing to judge."""
    if now.ended != ONGOING:
        return LOST
    arrived = before.passing and before.target != NO_PLAYER and now.holder == before.target
    return KEPT if arrived else None


def make_clips(schedule: Schedule) -> list[Clip]:
    """Return the clip of each trial, in order: they follow from the schedule alone.

    Trials take the first possession that is long enough for their foreperiod, each possession once. A trial
    in which nothing comes shows play without a mark, which outlasts the time-out.

    Raises:
        ValueError: no possession is as long as a trial needs.
    """
    possessions = _possessions(schedule)
    spare: deque[list[PitchFrame]] = deque()
    clips = []
    for plan in schedule.trials:
        seconds = plan.foreperiod_s + (schedule.config.time_out_s if plan.catch else 0.0)
        n_ticks = int(1000 * seconds / cycle_ms(schedule)) + 1
        rng = stream(schedule.root_seed, "feedback-lag clip", plan.index)
        wanted = (KEPT, LOST)[int(rng.integers(2))] if plan.catch else plan.condition
        looked_at: list[list[PitchFrame]] = []
        while True:
            frames = spare.popleft() if spare else next(possessions)
            place = _event_at(frames, wanted, n_ticks)
            if place is not None:
                break
            looked_at.append(frames)
        spare.extendleft(reversed(looked_at[-100:]))
        event = frames[place]
        clips.append(
            Clip(
                before=tuple(frames[place - n_ticks : place]),
                event=event,
                note=f"{wanted}, episode {event.episode}, cycle {event.cycle}: {event.caption()}",
            )
        )
    return clips


def _event_at(frames: list[PitchFrame], wanted: str, n_before: int) -> int | None:
    """Return the place of the first wanted event with enough pictures before it."""
    places = (i for i in range(n_before, len(frames)) if frames[i].time_s <= LONGEST_S)
    return next((i for i in places if judged(frames[i - 1], frames[i]) == wanted), None)


def _possessions(schedule: Schedule) -> Iterator[list[PitchFrame]]:
    """Yield episodes of one match, each as all its pictures."""
    # Here, not above: compiled code, and the screen's process imports this module.
    from core.keepaway.viewed_match import ViewedMatch

    match = ViewedMatch(KeepawayConfig(), "hand", stream_seed(schedule.root_seed, "feedback-lag match"))
    for _ in range(MOST_EPISODES):
        frames = [match.frame]
        while match.frame.ended == ONGOING:
            frames.append(match.step())
        yield frames
        match.next_episode()
    raise ValueError(f"none of {MOST_EPISODES} possessions is long enough: shorten foreperiods or time-out")


def main() -> None:
    """Read a schedule from the standard input, write its clips to the standard output, both JSON."""
    from arl_tui.app.compile_order import is_compiled, match_order
    from core.numerics.interpreting import start_interpreting

    schedule = msgspec.json.decode(sys.stdin.buffer.read(), type=Schedule)
    if not is_compiled(match_order(KeepawayConfig())):
        start_interpreting()  # half the time of compiling
    sys.stdout.buffer.write(msgspec.json.encode(make_clips(schedule)))


if __name__ == "__main__":
    main()
