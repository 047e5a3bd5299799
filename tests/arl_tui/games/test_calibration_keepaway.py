"""Feedback lag with Keepaway: which event is judged, what is shown before it, and where the result goes."""

from itertools import pairwise
from pathlib import Path

import msgspec
import pytest
from textual.geometry import Size

from arl_tui.calibration.plan import configure, newest_complete
from arl_tui.calibration.trial_screen import TrialScreen
from arl_tui.games.keepaway.judging import KEPT, LONGEST_S, LOST, MARK, Clip, judged, make_clips
from arl_tui.games.keepaway.trial_view import PitchTrialView
from arl_tui.palette import STANDARD
from arl_tui.participants import ParticipantError, choose_credit, keep_delay
from arl_tui.widgets.pitch_drawing import draw, fit, plain
from core.keepaway.picture import END_REASONS, PitchFrame, PlayerView
from core.keepaway.pitch import ONGOING, OUT, TAKEN
from studies.reaction_time.schedule import make_schedule
from tests.arl_tui.calibrating import (
    files_in,
    go_through,
    in_this_process,
    quick,
    quick_app,
    setup,
    trial_in,
    until,
)
from tests.arl_tui.test_participants import LAG, task_delay

PLACES = ((-8.0, -8.0), (8.0, -8.0), (-8.0, 8.0), (0.0, 0.0), (1.0, 1.0))


def frame(cycle: int, **changes: object) -> PitchFrame:
    given = {
        "length_m": 20.0,
        "width_m": 20.0,
        "n_keepers": 3,
        "players": tuple(PlayerView(x, y, 0.0) for x, y in PLACES),
        "ball": (-8.0 + cycle * 0.5, -8.0),
        "cycle": cycle,
        "holder": 0,
        "decider": 0,
    }
    return PitchFrame(**{**given, **changes})


@pytest.mark.parametrize(
    ("before", "now", "expected"),
    [
        ({"target": 1, "holder": -1}, {"target": 1, "holder": 1}, KEPT),
        ({"target": 1, "holder": -1}, {"target": 1, "holder": 2}, None),  # Somebody else's feet.
        ({"target": 1, "holder": -1}, {"target": 1, "holder": -1}, None),
        ({"target": -1, "holder": 0}, {"target": -1, "holder": 0}, None),  # Holds the ball.
        ({"target": 1, "holder": -1}, {"target": 1, "holder": 3, "ended": TAKEN}, LOST),
        ({"target": -1, "holder": 0}, {"target": -1, "holder": -1, "ended": OUT}, LOST),
    ],
)
def test_a_pass_that_arrives_and_the_end_of_an_episode_are_judged_nothing_else(before, now, expected) -> None:
    assert judged(frame(3, **before), frame(4, **now)) == expected


@pytest.mark.jit
def test_each_trial_plays_its_foreperiod_of_one_possession_up_to_its_event() -> None:
    (config,) = configure(["feedback-lag"], n_trials=8, n_practice=0, game="keepaway")
    schedule = make_schedule(msgspec.structs.replace(config, catch_rate=0.25), 4)
    clips = make_clips(schedule)
    assert len(clips) == 8
    assert {trial.condition for trial in schedule.trials} == {KEPT, LOST, "catch"}
    shown: set[tuple[int, int]] = set()
    for trial, clip in zip(schedule.trials, clips, strict=True):
        waited_s = trial.foreperiod_s + (config.time_out_s if trial.catch else 0.0)
        assert config.picture_ms == 500.0  # a fifth of the game's own speed, as sessions have it
        assert 0.0 <= 0.5 * len(clip.before) - waited_s <= 0.5 + 1e-9
        everything = [*clip.before, clip.event]
        assert all((b.episode, b.cycle - a.cycle) == (a.episode, 1) for a, b in pairwise(everything))
        assert all(one.ended == ONGOING for one in clip.before)
        event = judged(clip.before[-1], clip.event)
        assert event == trial.condition or trial.catch
        assert f"episode {clip.event.episode}, cycle {clip.event.cycle}" in clip.note
        shown.add((clip.event.episode, clip.event.cycle))
    assert len(shown) == 8
    assert make_clips(schedule) == clips


def test_play_slides_from_cycle_to_cycle_reaches_the_last_at_the_event_and_shows_nothing_of_it() -> None:
    n_before, foreperiod_s = 12, 1.13
    clip = Clip(before=tuple(frame(k) for k in range(n_before)), event=frame(99), note="")
    (config,) = configure(["feedback-lag"], n_trials=1, n_practice=0, game="keepaway")
    trial = make_schedule(config, 4).trials[0]
    plan = msgspec.structs.replace(trial, index=0, foreperiod_s=foreperiod_s, catch=False)
    view = PitchTrialView([clip], STANDARD, 100.0)
    shown: list[PitchFrame] = []
    view.pitch.show = lambda picture, number=-1: shown.append(picture)  # type: ignore[method-assign]
    assert view.tick_ns is not None
    ticks = range(int(foreperiod_s * 1e9 / view.tick_ns) + 1)
    for tick in ticks:
        view.wait(plan, tick)
    ball_x = [picture.ball[0] for picture in shown]
    steps = [b - a for a, b in pairwise(ball_x)]
    # Half a metre per cycle, three pictures per cycle; it stands still for the 30 ms that are no whole cycle.
    assert steps[2:] == pytest.approx([0.5 / 3] * (len(steps) - 2))
    last_x = clip.before[-1].ball[0]
    assert last_x - 0.5 / 3 < ball_x[-1] <= last_x
    view.wait(plan, 10 * len(ticks))
    assert shown[-1] == clip.before[-1]
    view.present(plan)
    assert shown[-1] == clip.event


async def made_by_hand(module: str, question: object) -> bytes:
    if not module.endswith("clips"):
        return await in_this_process(module, question)
    still = tuple(frame(5) for _ in range(9))
    # The event looks exactly like the picture before it: only the mark is new.
    return msgspec.json.encode([Clip(before=still, event=frame(5), note="by hand")] * len(question.trials))


async def test_a_participant_judges_a_marked_picture_of_the_pitch(tmp_path: Path) -> None:
    app = quick_app(setup(tmp_path, quick("feedback-lag", game="keepaway")), helper=made_by_hand)
    async with app.run_test(size=(80, 24)) as pilot:
        await go_through(pilot, until_shown=TrialScreen)
        await until(pilot, trial_in(pilot, "shown"))
        assert isinstance(pilot.app.screen, TrialScreen)
        view = pilot.app.screen._view
        assert isinstance(view, PitchTrialView)
        assert view.pitch.note == MARK
        assert view.pitch.size == Size(34, 20)
        assert "Too small" not in "".join(str(view.pitch.render_line(y).text) for y in range(20))
        await go_through(pilot)
    (file,) = files_in(tmp_path)
    assert [record.status for record in file.trials] == ["ok", "ok"]
    assert {record.comment for record in file.trials} == {"by hand"}
    (path,) = (tmp_path / "calibration").iterdir()
    assert path.name.startswith("P01-feedback-lag-keepaway-")
    assert list(newest_complete(tmp_path, "feedback lag", "keepaway")) == [path]
    assert list(newest_complete(tmp_path, "feedback lag")) == []


@pytest.mark.parametrize("detail", ["ascii", "half", "braille"])
@pytest.mark.parametrize(
    "event",
    [
        *({"holder": -1, "ended": reason} for reason in range(len(END_REASONS)) if reason != ONGOING),
        {"holder": -1, "target": 1, "decider": 0},
        {"holder": 1},
    ],
    ids=str,
)
def test_nothing_but_the_players_and_the_ball_says_how_it_ended(event, detail) -> None:
    pitch = PitchTrialView([Clip(before=(frame(1),), event=frame(2), note="")], STANDARD, 500.0).pitch
    assert pitch.styles.width is not None
    assert pitch.styles.height is not None
    shape = fit(20.0, 20.0, int(pitch.styles.width.value), int(pitch.styles.height.value))
    assert shape is not None
    picture, other = frame(990, time_s=LONGEST_S, **event), frame(990, time_s=LONGEST_S)
    last, others = (draw(each, shape, detail, MARK, caption=False)[-1] for each in (picture, other))
    assert last == others  # neither words nor colours
    assert MARK in plain((last,))[0]
    assert "".join(plain((last,))).count(" ") == 2  # NOW alone
    # The widget itself is drawn so.
    pitch._shape = shape
    pitch.show(picture)
    pitch.note = MARK
    assert pitch._rows[-1] == draw(picture, shape, pitch.detail, MARK, caption=False)[-1]


def test_a_session_of_keepaway_takes_the_delay_that_was_measured_with_keepaway(tmp_path: Path) -> None:
    keep_delay(tmp_path, "P01", task_delay())
    with pytest.raises(ParticipantError, match="--tasks feedback-lag --game keepaway"):
        choose_credit("feedback-lag", tmp_path, "P01", "keepaway")
    slower = msgspec.structs.replace(LAG, offset_s=0.3)
    keep_delay(tmp_path, "P01", task_delay(delay=slower, game="keepaway"))
    choice = choose_credit("participant", tmp_path, "P01", "keepaway")
    assert choice.delay == slower
    assert choice.source["credit_task"] == "feedback lag, keepaway"
    assert choose_credit("participant", tmp_path, "P01").delay == LAG
