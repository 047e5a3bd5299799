"""A session that broke off goes on after its last finished game, and both files replay as one session."""

from collections.abc import Iterable
from itertools import count
from pathlib import Path

import msgspec
import pytest

from core.events import (
    EpisodeEnded,
    EpisodeStarted,
    Event,
    FrameShown,
    Input,
    KeyPressed,
    SessionEnded,
    StepTaken,
    StopAsked,
    TimeGap,
    UnseenPlayed,
)
from core.numerics.clock import NS_PER_S, ManualClock
from core.recording.joined import ResumeError, finished_part, joined, latest_ns, read_session
from core.recording.publish import publish_folder
from core.recording.reader import Recording, RecordingError, read_recording
from core.recording.recorder import LineWriter
from core.recording.summary import summarise_recording
from core.session.protocol_reading import protocol_from
from core.session.replay import replay_exactly
from core.session.resume import ResumedSession
from core.session.session import build_session
from core.session.what_if import relearn, watched_steps
from tests.core.sessions import simulated

LATER_NS = 10**15
"""A clock that has run on."""
AFTER_A_RESTART_NS = 5 * NS_PER_S
"""A clock that began again: the computer was switched off."""


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    """A finished session of three games, as a participant's would be recorded."""
    folder = tmp_path_factory.mktemp("whole")
    recording = simulated(folder)
    return written(folder / "live.jsonl", recording, map(by_a_person, recording.events), whole=True)


def by_a_person(event: Event) -> Event:
    if isinstance(event, KeyPressed):
        return msgspec.structs.replace(event, source="participant")
    return event


def written(path: Path, like: Recording, events: Iterable[Event], *, whole: bool = False) -> Recording:
    """Write a live recording with these events; without an end line unless it is whole."""
    writer = LineWriter(path, msgspec.structs.replace(like.header, origin="live"))
    for event in events:
        writer.append(event)
    writer.close() if whole else writer.abandon()
    return read_recording(path)


def cut(whole: Recording, folder: Path, n_events: int, *more: Event) -> Recording:
    """Return the session as a kill after `n_events` leaves it."""
    return written(folder / "first.jsonl", whole, (*whole.events[:n_events], *more))


class Participant:
    """Sees every step, and praises every second one; stops at a step of their choice."""

    def __init__(self, clock: ManualClock, earlier: tuple[Event, ...], stop_at: int | None = None) -> None:
        self.recorded: list[Input] = []
        self._clock = clock
        self._presses = count(
            1 + max((event.press for event in earlier if isinstance(event, KeyPressed)), default=-1)
        )
        self._frames = count(
            1 + max((event.frame for event in earlier if isinstance(event, FrameShown)), default=-1)
        )
        self._stop_at = stop_at
        joint = TimeGap(last_ns=latest_ns(earlier), time_ns=clock.now_ns(), joint=True)
        self._waiting: list[Input] = [joint]

    def during(self, step: int) -> list[Input]:
        items, self._waiting = self._waiting, []
        if step >= 0:
            self._clock.advance_ns(NS_PER_S)
            now_ns = self._clock.now_ns()
            frame = next(self._frames)
            items.append(FrameShown(frame=frame, step=step, flushed_ns=now_ns))
            if step % 2:
                items.append(
                    KeyPressed(
                        press=next(self._presses),
                        time_ns=now_ns + NS_PER_S // 2,
                        key="j",
                        value=1.0,
                        frame=frame,
                        step=step,
                        verdict="accepted",
                    )
                )
            self._clock.advance_ns(NS_PER_S)
            if step == self._stop_at:
                items.append(StopAsked(time_ns=self._clock.now_ns(), reason="window-closed"))
        self.recorded += items
        return items


def gone_on_with(
    first: Recording, path: Path, *, now_ns: int = LATER_NS, stop_at: int | None = None
) -> Recording:
    """Let a session go on, recorded in a new file, as the screen's process records it."""
    whole = joined(first)
    kept = finished_part(whole, now_ns)
    clock = ManualClock(now_ns)
    participant = Participant(clock, kept.events, stop_at)
    session = ResumedSession(built(first), kept)
    session.catch_up()
    writer = LineWriter(path, msgspec.structs.replace(first.header, resumes=kept.resumes))
    for output in session.run(participant, clock):
        for item in participant.recorded:
            writer.append(item)
        participant.recorded.clear()
        writer.append(output)
    writer.close()
    return read_recording(path)


def built(recording: Recording):
    return build_session(protocol_from(recording.header.protocol), recording.header.root_seed)


def games(recording: Recording) -> list[EpisodeEnded]:
    return [event for event in recording.events if isinstance(event, EpisodeEnded)]


def places(whole: Recording) -> list[int]:
    """After how many events a session is cut: at every kind of boundary after the first game, and within
    games."""
    ends = [at for at, event in enumerate(whole.events) if isinstance(event, EpisodeEnded)]
    unseen = [at for at, event in enumerate(whole.events) if isinstance(event, UnseenPlayed)]
    starts = [at for at, event in enumerate(whole.events) if isinstance(event, EpisodeStarted)]
    near = {at + by for at in (*ends, *unseen, *starts[1:]) for by in (1, 2, 3)}
    near |= set(range(ends[0] + 1, len(whole.events) - 1, 13))
    return sorted(at for at in near if ends[0] < at < len(whole.events))


@pytest.mark.parametrize("now_ns", [LATER_NS, AFTER_A_RESTART_NS], ids=["later", "after a restart"])
def test_wherever_it_is_killed_both_files_are_one_exact_session(
    whole: Recording, tmp_path: Path, now_ns: int
) -> None:
    for n_events in places(whole):
        folder = tmp_path / str(n_events)
        first = cut(whole, folder, n_events)
        before = first.path.read_bytes()
        second = gone_on_with(first, folder / "second.jsonl", now_ns=now_ns)
        session = read_session(second.path)
        result = replay_exactly(session, built(session))
        assert result.difference is None, n_events
        assert result.outputs == len(session.outputs)
        assert first.path.read_bytes() == before
        # Games that were finished before the kill are the same ones, and are not played again.
        n_before = len(games(first))
        assert [game.digest for game in games(session)[:n_before]] == [game.digest for game in games(first)]
        assert len(games(session)) == 3
        assert isinstance(session.events[-1], SessionEnded)


def test_numbers_and_times_go_on(whole: Recording, tmp_path: Path) -> None:
    second = gone_on_with(
        cut(whole, tmp_path, len(whole.events) - 30), tmp_path / "b.jsonl", now_ns=AFTER_A_RESTART_NS
    )
    session = read_session(second.path)
    presses = [event.press for event in session.inputs if isinstance(event, KeyPressed)]
    steps = [event.step for event in session.outputs if isinstance(event, StepTaken)]
    assert presses == list(range(len(presses)))
    assert steps == list(range(len(steps)))
    taken = [event.inputs for event in session.outputs if hasattr(event, "inputs")]
    assert taken == sorted(taken)
    times = [event.time_ns for event in session.outputs if hasattr(event, "time_ns")]
    assert times == sorted(times)
    assert max(latest_ns((event,)) for event in session.events[: -len(second.events)]) < AFTER_A_RESTART_NS


def test_no_press_is_credited_across_the_joint(whole: Recording, tmp_path: Path) -> None:
    first = cut(whole, tmp_path, len(whole.events) - 30)
    second = gone_on_with(first, tmp_path / "b.jsonl")
    session = read_session(second.path)
    steps_before = {
        event.step for event in session.events[: -len(second.events)] if isinstance(event, StepTaken)
    }
    new = {event.press for event in second.events if isinstance(event, KeyPressed)}
    credited = [event for event in second.events if event.__class__.__name__ == "CreditGiven"]
    assert any(event.press in new for event in credited)
    assert not any(set(event.steps) & steps_before for event in credited if event.press in new)


def test_a_session_may_break_off_several_times(whole: Recording, tmp_path: Path) -> None:
    first = cut(whole, tmp_path, places(whole)[0])
    n_steps = 1 + max(event.step for event in first.outputs if isinstance(event, StepTaken))
    second = gone_on_with(first, tmp_path / "b.jsonl", stop_at=n_steps + 2)
    assert games(second)[0].ended != "termination"
    third = gone_on_with(second, tmp_path / "c.jsonl", now_ns=AFTER_A_RESTART_NS, stop_at=n_steps + 14)
    fourth = gone_on_with(third, tmp_path / "d.jsonl", now_ns=LATER_NS)
    session = read_session(fourth.path)
    assert [path.name for path in session.older] == ["first.jsonl", "b.jsonl", "c.jsonl"]
    assert replay_exactly(session, built(session)).difference is None
    summary = summarise_recording(session)
    assert (summary.games_finished, summary.games_planned, summary.gaps) == (3, 3, 0)
    assert summary.ending.kind == "finished"


def test_a_game_that_a_stop_cut_short_is_not_finished(whole: Recording, tmp_path: Path) -> None:
    first = cut(whole, tmp_path, places(whole)[0])
    n_steps = 1 + max(event.step for event in first.outputs if isinstance(event, StepTaken))
    second = gone_on_with(first, tmp_path / "b.jsonl", stop_at=n_steps + 2)
    assert len(games(second)) == 1
    kept = finished_part(joined(second), LATER_NS)
    assert kept.games == 1
    assert not any(isinstance(event, StopAsked | SessionEnded) for event in kept.events)


def test_a_what_if_takes_both_files_as_one(whole: Recording, tmp_path: Path) -> None:
    second = gone_on_with(cut(whole, tmp_path, len(whole.events) - 30), tmp_path / "b.jsonl")
    session = read_session(second.path)
    protocol = protocol_from(session.header.protocol)
    again = relearn(session, protocol, watched_steps(session, protocol), root_seed=session.header.root_seed)
    recorded = [event for event in session.events if event.__class__.__name__ == "CreditGiven"]
    assert again.credits == recorded
    assert again.agent.digest() == session.outputs[-1].digest


def test_a_session_that_comes_out_otherwise_is_not_gone_on_with(whole: Recording, tmp_path: Path) -> None:
    events = list(whole.events[: places(whole)[-1]])
    at = next(at for at, event in enumerate(events) if isinstance(event, StepTaken) and event.step == 3)
    events[at] = msgspec.structs.replace(events[at], reward=99.0)
    first = written(tmp_path / "first.jsonl", whole, events)
    with pytest.raises(ResumeError, match=r"comes out otherwise now: output \d+: reward was 99\.0"):
        gone_on_with(first, tmp_path / "b.jsonl")


def test_what_cannot_go_on_is_refused(whole: Recording, tmp_path: Path) -> None:
    with pytest.raises(ResumeError, match="is finished: there is nothing left to do"):
        finished_part(whole, LATER_NS)
    with pytest.raises(
        ResumeError, match=f"no game was finished: begin anew .*--seed {whole.header.root_seed}"
    ):
        finished_part(cut(whole, tmp_path, 10), LATER_NS)
    (tmp_path / "s").mkdir()
    with pytest.raises(ResumeError, match="of origin simulated"):
        finished_part(simulated(tmp_path / "s"), LATER_NS)


def test_the_older_file_must_be_there_and_unchanged(whole: Recording, tmp_path: Path) -> None:
    first = cut(whole, tmp_path, len(whole.events) - 30)
    second = gone_on_with(first, tmp_path / "b.jsonl")
    content = first.path.read_bytes()
    first.path.unlink()
    with pytest.raises(RecordingError, match=r"goes on with first\.jsonl, which is not in its folder"):
        read_session(second.path)
    first.path.write_bytes(content[: content[:-1].rindex(b"\n") + 1])  # a line less: still a sound recording
    with pytest.raises(RecordingError, match=r"not as it was when b\.jsonl went on with it"):
        read_session(second.path)


def test_published_copies_are_one_session_too(whole: Recording, tmp_path: Path) -> None:
    first = cut(whole, tmp_path, len(whole.events) - 30)
    second = gone_on_with(first, tmp_path / "second.jsonl")
    copies = dict(publish_folder([second.path, first.path], tmp_path / "out"))
    session = read_session(copies[second.path])
    assert session.events == read_session(second.path).events
    assert replay_exactly(session, built(session)).difference is None
