"""What a calibration consists of, and what of it is done."""

from pathlib import Path

import pytest

from arl_tui.calibration.plan import (
    Part,
    configure,
    minutes_left,
    new_parts,
    newest_complete,
    task_names,
    unfinished,
)
from arl_tui.calibration.stimulus import COLUMNS, ROWS, drawing
from arl_tui.games.registry import screens_called
from arl_tui.recordings import all_recordings
from core.plugins import GameError, plugins
from studies.lab.folder import participant_folder
from studies.reaction_time.schedule import make_schedule
from studies.reaction_time.tasks import MAKERS
from tests.arl_tui.calibrating import quick, setup
from tests.arl_tui.trial_files import write_session

NOW = "2026-11-22T10:00:00+00:00"


# --- tasks --------------------------------------------------------------------------------------------------


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
    assert 5.0 < minutes_left(new_parts(setup(tmp_path, *usual))) < 10.0


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


# --- what is done -------------------------------------------------------------------------------------------


def test_nothing_is_unfinished_before_the_first_and_after_a_whole_sitting(tmp_path: Path) -> None:
    given = setup(tmp_path, quick("simple"))
    assert unfinished(given, NOW) is None
    write_session(tmp_path, "P01", new_parts(given)[0].schedule, [0.3, 0.4])
    assert unfinished(given, NOW) is None


def test_an_unfinished_sitting_goes_on_with_its_own_seed_also_in_tasks_not_begun(tmp_path: Path) -> None:
    both = quick("simple"), quick("choice")
    first = setup(tmp_path, *both, seed=3)
    path = write_session(tmp_path, "P01", new_parts(first)[0].schedule, [0.3], planned=first.planned)
    found = unfinished(setup(tmp_path, *both, seed=8), NOW)
    assert found is not None
    assert (found.root_seed, found.age_h, found.is_old) == (3, 2.0, False)
    simple, choice = found.parts
    assert (simple.path, simple.done, simple.complete) == (path, frozenset({0}), False)
    assert choice == Part(make_schedule(both[1], 3))


def test_a_sitting_that_stopped_between_two_tasks_is_unfinished(tmp_path: Path) -> None:
    both = setup(tmp_path, quick("simple"), quick("choice"))
    write_session(tmp_path, "P01", new_parts(both)[0].schedule, [0.3, 0.4], planned=both.planned)
    found = unfinished(both, NOW)
    assert found is not None
    assert [part.complete for part in found.parts] == [True, False]


def test_other_tasks_or_another_person_are_another_sitting(tmp_path: Path) -> None:
    given = setup(tmp_path, quick("simple"))
    schedule = new_parts(given)[0].schedule
    write_session(tmp_path, "P01", schedule, [0.3], planned="simple,choice")
    write_session(tmp_path, "P01-b", schedule, [0.3], created="2026-11-22T09:00:00+00:00")
    assert unfinished(given, NOW) is None


def test_a_sitting_is_old_after_twelve_hours(tmp_path: Path) -> None:
    given = setup(tmp_path, quick("simple"))
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


def test_in_a_study_the_group_is_all_participants_whose_folder_may_be_any_of_theirs(tmp_path: Path) -> None:
    schedule = make_schedule(quick("simple"), 3)
    folders = [participant_folder(tmp_path, code) for code in ("P01", "P02", "P03")]
    for folder in folders:
        folder.mkdir(parents=True)
    files = [
        write_session(folder, folder.name, schedule, [0.3, 0.3]) for folder in folders if folder.name != "P03"
    ]
    assert [set(newest_complete(folder, "simple")) for folder in folders] == [set(files)] * 3


def test_trial_files_are_not_taken_for_recordings_of_sessions(tmp_path: Path) -> None:
    write_session(tmp_path, "P01", make_schedule(quick("simple"), 3), [0.3])
    assert list(all_recordings(tmp_path)) == []


@pytest.mark.parametrize("plugin", list(plugins()), ids=lambda plugin: plugin.name)
def test_a_calibration_is_of_the_sessions_own_game_or_refused(plugin) -> None:
    (simple,) = configure(("simple",), game=plugin.name)
    assert simple.game == "tetris"  # as ever: no game is watched in this task
    if screens_called(plugin.name).judging_module:
        (lag,) = configure(("feedback-lag",), game=plugin.name)
        assert lag.game == plugin.name
    else:
        with pytest.raises(GameError, match=f"{plugin.title} has no feedback-lag task"):
            configure(("feedback-lag",), game=plugin.name)
