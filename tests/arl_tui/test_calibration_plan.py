"""What a calibration consists of, what of it is done, and what its command says and refuses."""

from pathlib import Path

import msgspec
import numpy as np
import pytest
from click.testing import CliRunner

from arl_tui.calibration.fitting import FitOrder, fit_files
from arl_tui.calibration.plan import (
    PLANNED,
    Part,
    configure,
    minutes_left,
    new_parts,
    newest_complete,
    task_names,
    unfinished,
)
from arl_tui.calibration.scenes import HOVER_HEIGHT, N_WORST, Scene, hover_path, make_scenes
from arl_tui.calibration.stimulus import COLUMNS, ROWS, drawing
from arl_tui.cli import main
from arl_tui.commands import calibrate as command
from arl_tui.participants import choose_credit, read_delays
from arl_tui.recordings import all_recordings
from core.feedback.credit import GammaDelay
from core.streams import stream
from core.tetris.game import FallingPiece, Primitive, at_rest, landing_row, moved
from core.tetris.picture import FALLING, GHOST, Wall
from studies.reaction_time.protocol import Schedule, TrialRecord
from studies.reaction_time.schedule import make_schedule
from studies.reaction_time.tasks import MAKERS
from studies.reaction_time.trial_log import TrialHeader, TrialWriter
from tests.arl_tui.calibrating import quick, sitting

NOW = "2026-11-22T10:00:00+00:00"


def record_of(schedule: Schedule, trial: int, rt_s: float | None, **changes) -> TrialRecord:
    plan, block = schedule.trials[trial], schedule.block_of(trial)
    onset = trial * 10**10
    given = {
        "trial": trial,
        "block": block.index,
        "task": schedule.config.task,
        "practice": block.practice,
        "catch": plan.catch,
        "condition": plan.condition,
        "stimulus": plan.stimulus,
        "expected_keys": plan.expected_keys,
        "foreperiod_s": plan.foreperiod_s,
        "started_ns": onset - 10**9,
        "asked_ns": onset,
        "flushed_ns": onset,
        "key": None if rt_s is None else plan.expected_keys[0],
        "key_ns": None if rt_s is None else onset + round(rt_s * 1e9),
        "rt_s": rt_s,
        "status": "time-out" if rt_s is None else "ok",
        "early_presses": 0,
        "other_presses": 0,
        "frame_interval_ns": 10**7,
        "time_out_s": schedule.config.time_out_s,
        "ended_ns": onset + 2 * 10**9,
    }
    return TrialRecord(**{**given, **changes})


def write_session(
    folder: Path,
    participant: str,
    schedule: Schedule,
    times_s: list[float],
    *,
    planned: str = "simple",
    created: str = "2026-11-22T08:00:00+00:00",
) -> Path:
    """Write a session whose first trials have these times."""
    stamp = created[:19].replace("-", "").replace(":", "") + "Z"
    path = folder / "calibration" / f"{participant}-{planned.split(',')[0]}-{stamp}.jsonl"
    path.parent.mkdir(parents=True, exist_ok=True)
    header = TrialHeader(
        participant=participant, created_utc=created, schedule=schedule, facts={PLANNED: planned}
    )
    with TrialWriter.create(path, header) as writer:
        for trial, rt_s in enumerate(times_s):
            writer.write(record_of(schedule, trial, rt_s))
    return path


# --- tasks ------------------------------------------------------------------------------------------------------


def test_tasks_come_in_our_order_each_once_and_all_can_be_named() -> None:
    assert task_names("feedback-lag, simple,simple") == ("simple", "feedback-lag")
    every = "simple,choice,go-no-go,memory-search,visual-search,recognition,feedback-lag"
    assert {config.task for config in configure(task_names(every))} == set(MAKERS)
    with pytest.raises(ValueError, match="unknown task 'reading'"):
        task_names("simple,reading")
    with pytest.raises(ValueError, match="choose from simple"):
        task_names(" , ")


def test_the_usual_calibration_takes_five_to_ten_minutes(tmp_path: Path) -> None:
    usual = configure(("simple", "choice", "feedback-lag"))
    assert 5.0 < minutes_left(new_parts(sitting(tmp_path, *usual))) < 10.0


def test_numbers_of_trials_can_be_chosen_and_judging_waits_longest() -> None:
    simple, lag = configure(("simple", "feedback-lag"), n_trials=12, n_practice=0)
    assert (simple.n_trials, simple.n_practice, lag.n_trials) == (12, 0, 12)
    assert lag.time_out_s == 3.0


@pytest.mark.parametrize("task", MAKERS)
def test_every_stimulus_fits_into_its_box(task: str) -> None:
    (config,) = (config for config in configure(tuple(_names())) if config.task == task)
    for plan in make_schedule(config, 5).trials:
        for shown in (plan.stimulus, *plan.study_items):
            lines = drawing(shown)
            assert len(lines) <= ROWS
            assert all(len(line) == len(lines[0]) <= COLUMNS for line in lines)


def _names() -> list[str]:
    return ["simple", "choice", "go-no-go", "memory-search", "visual-search", "recognition", "feedback-lag"]


# --- what is done -----------------------------------------------------------------------------------------------


def test_nothing_is_unfinished_before_the_first_and_after_a_whole_sitting(tmp_path: Path) -> None:
    given = sitting(tmp_path, quick("simple"))
    assert unfinished(given, NOW) is None
    write_session(tmp_path, "P01", new_parts(given)[0].schedule, [0.3, 0.4])
    assert unfinished(given, NOW) is None


def test_an_unfinished_sitting_goes_on_with_its_own_seed_also_in_tasks_not_begun(tmp_path: Path) -> None:
    both = quick("simple"), quick("choice")
    first = sitting(tmp_path, *both, seed=3)
    path = write_session(tmp_path, "P01", new_parts(first)[0].schedule, [0.3], planned=first.planned)
    found = unfinished(sitting(tmp_path, *both, seed=8), NOW)
    assert found is not None
    assert (found.root_seed, found.age_h, found.is_old) == (3, 2.0, False)
    simple, choice = found.parts
    assert (simple.path, simple.done, simple.complete) == (path, frozenset({0}), False)
    assert choice == Part(make_schedule(both[1], 3))


def test_a_sitting_that_stopped_between_two_tasks_is_unfinished(tmp_path: Path) -> None:
    both = sitting(tmp_path, quick("simple"), quick("choice"))
    write_session(tmp_path, "P01", new_parts(both)[0].schedule, [0.3, 0.4], planned=both.planned)
    found = unfinished(both, NOW)
    assert found is not None
    assert [part.complete for part in found.parts] == [True, False]


def test_other_tasks_or_another_person_are_another_sitting(tmp_path: Path) -> None:
    given = sitting(tmp_path, quick("simple"))
    schedule = new_parts(given)[0].schedule
    write_session(tmp_path, "P01", schedule, [0.3], planned="simple,choice")
    write_session(tmp_path, "P01-b", schedule, [0.3], created="2026-11-22T09:00:00+00:00")
    assert unfinished(given, NOW) is None


def test_a_sitting_is_old_after_twelve_hours(tmp_path: Path) -> None:
    given = sitting(tmp_path, quick("simple"))
    write_session(tmp_path, "P01", new_parts(given)[0].schedule, [0.3])
    found = unfinished(given, "2026-11-22T20:01:00+00:00")
    assert found is not None
    assert found.is_old


def test_only_the_newest_finished_session_of_each_person_counts_for_the_group(tmp_path: Path) -> None:
    schedule = make_schedule(quick("simple"), 3)
    write_session(tmp_path, "P01", schedule, [0.3, 0.3], created="2026-11-20T08:00:00+00:00")
    newer = write_session(tmp_path, "P01", schedule, [0.3, 0.3], created="2026-11-21T08:00:00+00:00")
    write_session(tmp_path, "P01", schedule, [0.3], created="2026-11-22T08:00:00+00:00")
    other = write_session(tmp_path, "P02", schedule, [0.3, 0.3])
    assert set(newest_complete(tmp_path, "simple")) == {newer, other}


def test_trial_files_are_not_taken_for_recordings_of_sessions(tmp_path: Path) -> None:
    write_session(tmp_path, "P01", make_schedule(quick("simple"), 3), [0.3])
    assert list(all_recordings(tmp_path)) == []


# --- the watched game -------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def watched() -> tuple[Schedule, list[Scene]]:
    (config,) = configure(("feedback-lag",), n_trials=30, n_practice=0)
    schedule = make_schedule(config, 11)
    return schedule, make_scenes(schedule)


def test_good_is_the_experts_place_and_bad_one_of_the_worst(watched: tuple[Schedule, list[Scene]]) -> None:
    schedule, scenes = watched
    assert len(scenes) == len(schedule.trials)
    for plan, scene in zip(schedule.trials, scenes, strict=True):
        rank, total = (int(word) for word in scene.note.rpartition("rank ")[2].split(" of "))
        if plan.condition == "good placement":
            assert rank == 1
        elif plan.condition == "bad placement":
            assert rank > total - N_WORST


def test_a_piece_hovers_by_primitives_and_drops_straight_down(watched: tuple[Schedule, list[Scene]]) -> None:
    for scene in watched[1]:
        board = scene.wall.board
        for before, after in zip(scene.hover, scene.hover[1:], strict=False):
            ways = [before, *(moved(board, before, each) for each in Primitive if each is not Primitive.DROP)]
            assert after in ways
        assert at_rest(board, scene.hover[-1]) == scene.landed
        assert {place.row for place in scene.hover} == {scene.wall.rows - HOVER_HEIGHT}


def test_the_last_place_is_seen_for_less_than_a_tick_before_the_drop(
    watched: tuple[Schedule, list[Scene]],
) -> None:
    for plan, scene in zip(*((watched[0].trials, watched[1])), strict=True):
        if not plan.catch:
            before_ms = plan.foreperiod_s * 1000 - (len(scene.hover) - 1) * 150
            assert 0 <= before_ms < 150


def test_pictures_do_not_tell_where_the_piece_would_land(watched: tuple[Schedule, list[Scene]]) -> None:
    scene = watched[1][0]
    codes = scene.hovering(0).codes()
    assert [code & (FALLING | GHOST) for code in codes if code & (FALLING | GHOST)] == [FALLING] * 4


def test_the_event_marks_the_piece_that_dropped_and_where_it_came_from(
    watched: tuple[Schedule, list[Scene]],
) -> None:
    for scene in watched[1]:
        before, after = scene.hovering(10**6).codes(), scene.event().codes()
        hovered = [at for at, code in enumerate(before) if code & FALLING]
        assert [at for at, code in enumerate(after) if code & GHOST] == hovered
        landed = [at for at, code in enumerate(after) if code & FALLING]
        assert [at % 10 for at in landed] == [at % 10 for at in hovered]
        assert max(hovered) < min(landed)


def test_scenes_follow_from_the_schedule_and_survive_the_way_between_processes(
    watched: tuple[Schedule, list[Scene]],
) -> None:
    schedule, scenes = watched
    again = make_scenes(msgspec.json.decode(msgspec.json.encode(schedule), type=Schedule))
    assert msgspec.json.decode(msgspec.json.encode(again), type=list[Scene]) == scenes


def test_a_place_that_no_drop_reaches_is_an_error() -> None:
    wall = Wall(20, 10)
    row = landing_row(wall.board, 1, 0, 3)
    with pytest.raises(ValueError, match="cannot be reached"):
        hover_path(wall, FallingPiece(1, 0, row + 1, 3), 4, rng=stream(1, "test"))


# --- fit --------------------------------------------------------------------------------------------------------


def judgements(person: int, n: int, mean_s: float) -> list[float]:
    shape = 12.0
    return [float(t) for t in 0.1 + stream(7, "people", person).gamma(shape, (mean_s - 0.1) / shape, size=n)]


def test_a_fit_is_kept_per_task_and_pooled_from_five_people_on(tmp_path: Path) -> None:
    schedule = make_schedule(quick("feedback-lag", n_trials=30, time_out_s=3.0), 3)
    means = [0.55, 0.6, 0.65, 0.7, 0.75]
    paths = [
        write_session(tmp_path, f"P{k}", schedule, judgements(k, 30, mean), planned="feedback-lag")
        for k, mean in enumerate(means)
    ]
    order = FitOrder(recordings=str(tmp_path), participant="P4", files=(str(paths[4]),))
    (delay,) = fit_files(order).delays
    assert delay.n_observed == 30
    assert delay.mean_s.low < np.mean(judgements(4, 30, 0.75)) < delay.mean_s.high
    assert delay.pooled is not None
    assert delay.pooled_people == 5
    own, pooled = (d.offset_s + d.shape * d.scale_s for d in (delay.delay, delay.pooled))
    assert pooled < own  # the slowest of five is pulled towards the others
    assert read_delays(tmp_path, "P4") is not None
    assert choose_credit("participant", tmp_path, "P4").delay == delay.delay
    assert isinstance(choose_credit("pooled", tmp_path, "P4").delay, GammaDelay)


def test_too_few_answers_are_a_failure_with_its_reason_and_do_not_stop_other_tasks(tmp_path: Path) -> None:
    few = write_session(tmp_path, "P1", make_schedule(quick("simple"), 3), [0.3, 0.31])
    enough = write_session(
        tmp_path,
        "P1",
        make_schedule(quick("choice", n_trials=20), 3),
        judgements(1, 20, 0.5),
        planned="choice",
    )
    fitted = fit_files(FitOrder(recordings=str(tmp_path), participant="P1", files=(str(few), str(enough))))
    assert "2 usable responses" in fitted.failures["simple"]
    assert [delay.task for delay in fitted.delays] == ["choice"]
    assert fitted.delays[0].pooled is None


def test_numerical_trouble_in_one_task_leaves_the_others_and_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from studies.reaction_time import fit

    fit_as_usual = fit.fit_participant

    def fail_at_first(*arguments):
        monkeypatch.setattr(fit, "fit_participant", fit_as_usual)
        raise ValueError("f(a) and f(b) must have different signs")

    monkeypatch.setattr(fit, "fit_participant", fail_at_first)
    paths = [
        str(
            write_session(
                tmp_path, "P1", make_schedule(quick(name, n_trials=8), 3), judgements(1, 8, 0.5), planned=name
            )
        )
        for name in ("simple", "choice")
    ]
    fitted = fit_files(FitOrder(recordings=str(tmp_path), participant="P1", files=tuple(paths)))
    assert "different signs" in fitted.failures["simple"]
    assert [delay.task for delay in fitted.delays] == ["choice"]


def test_somebody_elses_damaged_file_stops_the_pooling_only(tmp_path: Path) -> None:
    schedule = make_schedule(quick("simple", n_trials=8), 3)
    own = write_session(tmp_path, "P1", schedule, judgements(1, 8, 0.4))
    write_session(tmp_path, "P2", schedule, [0.3]).write_text("rubbish\n")
    fitted = fit_files(FitOrder(recordings=str(tmp_path), participant="P1", files=(str(own),)))
    assert "P2-simple" in fitted.failures["simple, pooled"]
    assert [delay.n_observed for delay in fitted.delays] == [8]


# --- command ----------------------------------------------------------------------------------------------------


def run(*arguments: str) -> tuple[int, str]:
    result = CliRunner().invoke(main, ["calibrate", *arguments])
    return result.exit_code, result.output


def test_a_dry_run_prints_every_trial_and_needs_no_terminal(tmp_path: Path) -> None:
    common = ("--participant", "P01", "--dry-run", "--recordings", str(tmp_path), "--tasks", "simple,choice")
    code, text = run(*common, "--seed", "4", "--trials", "6", "--practice", "2")
    assert code == 0
    assert "simple: 8 trials in 2 blocks, seed 4" in text
    assert "choice: 8 trials" in text
    assert run(*common, "--seed", "4", "--trials", "6", "--practice", "2") == (code, text)
    assert list(tmp_path.iterdir()) == []


def test_a_browser_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TEXTUAL_DRIVER", "web")
    code, text = run("--participant", "P01")
    assert code == 1
    assert "browser" in text


@pytest.mark.parametrize(
    ("variables", "found"),
    [
        ({}, []),
        ({"SSH_CONNECTION": "1.2.3.4 5 6.7.8.9 22"}, ["ssh"]),
        ({"TMUX": "/tmp/x,1,0"}, ["tmux"]),
        ({"STY": "1.pts"}, ["screen"]),
        ({"SSH_TTY": "/dev/pts/1", "TMUX": "/tmp/x,1,0"}, ["ssh", "tmux"]),
    ],
)
def test_network_and_multiplexers_are_noticed(
    monkeypatch: pytest.MonkeyPatch, variables: dict[str, str], found: list[str]
) -> None:
    for name in ("SSH_CONNECTION", "SSH_TTY", "TMUX", "STY"):
        monkeypatch.delenv(name, raising=False)
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    assert command.hindrances() == found


def test_refit_fits_what_is_there_and_pools_it_with_those_who_came_later(tmp_path: Path) -> None:
    arguments = ("--participant", "P0", "--refit", "--recordings", str(tmp_path), "--tasks", "simple,choice")
    code, text = run(*arguments)
    assert code == 1
    assert "has finished none of these tasks" in text
    schedule = make_schedule(quick("simple", n_trials=20), 3)
    for person in range(5):
        write_session(tmp_path, f"P{person}", schedule, judgements(person, 20, 0.4 + 0.02 * person))
    code, text = run(*arguments)
    assert code == 0, text
    assert "20 responses" in text
    assert "pooled with 4 others" in text
    known = read_delays(tmp_path, "P0")
    assert known is not None
    assert known.tasks["simple"].pooled_people == 5


def test_names_unknown_tasks_and_missing_terminals_are_refused(tmp_path: Path) -> None:
    assert run("--participant", "Jane Doe")[0] == 2
    code, text = run("--participant", "P01", "--tasks", "reading")
    assert code == 2
    assert "unknown task" in text
    code, text = run("--participant", "P01", "--recordings", str(tmp_path))
    assert code == 1
    assert "arl calibrate --dry-run" in text


def test_a_damaged_trial_file_is_named_before_anything_is_shown(tmp_path: Path) -> None:
    path = write_session(tmp_path, "P01", make_schedule(quick("simple"), 3), [0.3])
    path.write_text("rubbish\n")
    import click

    with pytest.raises(click.ClickException, match="Move the file away"):
        command.check_files(tmp_path, "P01")
