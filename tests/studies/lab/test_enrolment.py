"""Places, codes and sittings: who gets what, who may go on, and that no two participants share anything."""

import multiprocessing
from collections import Counter
from datetime import UTC, datetime, timedelta

import msgspec
import pytest

from core.numerics.clock import ManualClock
from studies.lab.enrolment import NotNow, begin_sitting, drawn_code, enrol, session_seed
from studies.lab.folder import participant_folder, sitting_path
from studies.lab.ledger import (
    Declined,
    DroppedOut,
    Enrolled,
    Ledger,
    LedgerError,
    SittingEnded,
    SittingStarted,
    StepDone,
    Withdrawn,
    read_ledger,
)
from studies.lab.orders import order_of
from studies.lab.progress import progress
from studies.lab.sitting_log import SittingLog
from tests.studies.lab.examples import study_of
from tests.studies.lab.test_sitting_log import HEADER

MORNING = datetime(2026, 11, 28, 9, 0, tzinfo=UTC)


@pytest.fixture
def study():
    return study_of()


@pytest.fixture
def ledger(tmp_path, study):
    return Ledger(tmp_path / "data", study=study.name, seed=study.seed)


def finish(ledger, code, sitting=0, at=MORNING):
    ledger.append(SittingEnded(code=code, sitting=sitting, how="finished", at_utc=at.isoformat()))


def test_participants_get_places_in_turn_with_the_places_orders(study, ledger):
    entries = [enrol(study, ledger, code, now=MORNING) for code in ("A", "B", "C")]
    assert [entry.place for entry in entries] == [0, 1, 2]
    assert [entry.order for entry in entries] == [order_of(study, place) for place in range(3)]


def test_a_code_takes_part_once(study, ledger):
    enrol(study, ledger, "A", now=MORNING)
    with pytest.raises(NotNow, match="A takes part already"):
        enrol(study, ledger, "A", now=MORNING)


def test_the_place_of_a_dropout_goes_to_the_next_participant(study, ledger):
    for code in ("A", "B", "C"):
        enrol(study, ledger, code, now=MORNING)
    ledger.append(DroppedOut(code="B", reason="moved away"))
    assert enrol(study, ledger, "D", now=MORNING).place == 1
    assert enrol(study, ledger, "E", now=MORNING).place == 3


def test_without_replacement_the_place_of_a_dropout_stays_empty(tmp_path):
    study = study_of(dropouts={"replace": False})
    ledger = Ledger(tmp_path, study=study.name, seed=study.seed)
    enrol(study, ledger, "A", now=MORNING)
    ledger.append(DroppedOut(code="A", reason="moved away"))
    assert enrol(study, ledger, "B", now=MORNING).place == 1


def test_who_gives_no_sign_of_life_for_long_counts_as_dropped_out(study, ledger):
    enrol(study, ledger, "A", now=MORNING)
    later = MORNING + timedelta(hours=study.dropouts.after_hours + 1)
    assert enrol(study, ledger, "B", now=later).place == 0


def test_who_has_finished_keeps_their_place_for_ever(study, ledger):
    enrol(study, ledger, "A", now=MORNING)
    begin_sitting(study, ledger, "A", now=MORNING)
    finish(ledger, "A")
    assert enrol(study, ledger, "B", now=MORNING + timedelta(days=1000)).place == 1


def test_finishers_are_balanced_whoever_drops_out(tmp_path):
    study = study_of(conditions=3)
    ledger = Ledger(tmp_path, study=study.name, seed=study.seed)
    number = 0
    while (
        sum(p.state(study, MORNING) == "finished" for p in progress(ledger.lines()).participants.values())
        < 12
    ):
        code = f"P{number}"
        enrol(study, ledger, code, now=MORNING)
        begin_sitting(study, ledger, code, now=MORNING)
        if number % 3 == 1:
            ledger.append(DroppedOut(code=code, reason="every third one"))
        else:
            finish(ledger, code)
        number += 1
    finished = [
        p.order
        for p in progress(ledger.lines()).participants.values()
        if p.state(study, MORNING) == "finished"
    ]
    for position in zip(*finished, strict=True):
        assert set(Counter(position).values()) == {4}


def _enrol_many(folder, names):
    study = study_of()
    ledger = Ledger(folder, study=study.name, seed=study.seed)
    for _ in names:
        enrol(study, ledger, drawn_code(study, ledger))


def test_computers_that_enrol_at_the_same_time_never_share_a_place_or_a_code(tmp_path):
    folder = tmp_path / "data"
    spawn = multiprocessing.get_context("spawn")
    runs = [spawn.Process(target=_enrol_many, args=(folder, range(5))) for _ in range(4)]
    for run in runs:
        run.start()
    for run in runs:
        run.join(60)
    enrolled = [line for line in read_ledger(folder / "ledger.jsonl") if isinstance(line, Enrolled)]
    assert sorted(line.place for line in enrolled) == list(range(20))
    assert len({line.code for line in enrolled}) == 20


def test_a_sitting_goes_on_after_its_last_finished_step(study, ledger):
    enrol(study, ledger, "A", now=MORNING)
    first = begin_sitting(study, ledger, "A", now=MORNING)
    for step in (0, 1):
        ledger.append(StepDone(code="A", sitting=0, step=step, at_utc=MORNING.isoformat()))
    again = begin_sitting(study, ledger, "A", now=MORNING + timedelta(hours=1))
    assert (first.first_step, again.first_step, again.resumed) == (0, 2, True)
    assert session_seed(study, first, 2) == session_seed(study, again, 2)


def test_a_sitting_that_begins_anew_has_seeds_of_its_own(tmp_path):
    study = study_of(resuming={"rule": "restart"})
    ledger = Ledger(tmp_path, study=study.name, seed=study.seed)
    enrol(study, ledger, "A", now=MORNING)
    first = begin_sitting(study, ledger, "A", now=MORNING)
    ledger.append(StepDone(code="A", sitting=0, step=0, at_utc=MORNING.isoformat()))
    again = begin_sitting(study, ledger, "A", now=MORNING)
    assert (again.first_step, again.resumed) == (0, False)
    assert session_seed(study, first, 1) != session_seed(study, again, 1)


def test_a_sitting_that_another_study_file_began_goes_on_only_by_the_experimenter(study, ledger):
    enrol(study, ledger, "A", now=MORNING)
    begin_sitting(study, ledger, "A", now=MORNING, sha256=HEADER.study_sha256)
    with SittingLog(sitting_path(ledger.folder, "A", 0, 0), HEADER, clock=ManualClock()):
        pass
    ledger.append(StepDone(code="A", sitting=0, step=0, at_utc=MORNING.isoformat()))
    with pytest.raises(NotNow, match="the study file was changed after A began the sitting 'day 1'"):
        begin_sitting(study, ledger, "A", now=MORNING, sha256="1" * 64)
    assert begin_sitting(study, ledger, "A", now=MORNING, sha256=HEADER.study_sha256).first_step == 1
    again = begin_sitting(study, ledger, "A", now=MORNING, sha256="1" * 64, decision="resume")
    assert again.first_step == 1


def test_an_old_sitting_is_never_resumed(study, ledger):
    enrol(study, ledger, "A", now=MORNING)
    begin_sitting(study, ledger, "A", now=MORNING)
    with pytest.raises(NotNow, match=r"ended early 24\.0 h ago; \[resuming\] within_hours allows 4 h"):
        begin_sitting(study, ledger, "A", now=MORNING + timedelta(days=1))


def test_where_the_study_refuses_to_resume_the_experimenter_decides(tmp_path):
    study = study_of(resuming={"rule": "refuse"})
    ledger = Ledger(tmp_path, study=study.name, seed=study.seed)
    enrol(study, ledger, "A", now=MORNING)
    begin_sitting(study, ledger, "A", now=MORNING)
    with pytest.raises(NotNow, match="leaves it to you"):
        begin_sitting(study, ledger, "A", now=MORNING)
    ledger.append(StepDone(code="A", sitting=0, step=0, at_utc=MORNING.isoformat()))
    resumed = begin_sitting(study, ledger, "A", now=MORNING, decision="resume")
    assert (resumed.first_step, resumed.resumed, resumed.anew) == (1, True, False)
    restarted = begin_sitting(study, ledger, "A", now=MORNING + timedelta(days=1), decision="restart")
    assert (restarted.first_step, restarted.resumed, restarted.anew) == (0, False, True)
    written = [line.decided for line in ledger.lines() if isinstance(line, SittingStarted)]
    assert written == [None, "resume", "restart"]


def test_a_decision_about_a_sitting_that_did_not_break_off_is_refused(study, ledger):
    enrol(study, ledger, "A", now=MORNING)
    with pytest.raises(NotNow, match="no sitting that broke off"):
        begin_sitting(study, ledger, "A", now=MORNING, decision="restart")


def two_days():
    steps = [{"type": "consent", "text": "consent.md"}, {"type": "block"}, {"type": "block"}]
    return study_of(
        sittings=[
            {"name": "day 1", "steps": steps},
            {
                "name": "day 2",
                "steps": [{"type": "debriefing", "text": "thanks.md"}],
                "after_hours": 12,
                "within_hours": 48,
            },
        ]
    )


@pytest.mark.parametrize(
    ("hours", "message"), [(11, r"may begin on 2026-11-28 at 21:00 UTC, 12 h after"), (49, "comes too late")]
)
def test_a_second_day_too_early_or_too_late_is_refused(tmp_path, hours, message):
    study = two_days()
    ledger = Ledger(tmp_path, study=study.name, seed=study.seed)
    enrol(study, ledger, "A", now=MORNING)
    begin_sitting(study, ledger, "A", now=MORNING)
    finish(ledger, "A")
    with pytest.raises(NotNow, match=message):
        begin_sitting(study, ledger, "A", now=MORNING + timedelta(hours=hours))


def test_a_second_day_in_time_begins_the_second_sitting(tmp_path):
    study = two_days()
    ledger = Ledger(tmp_path, study=study.name, seed=study.seed)
    enrol(study, ledger, "A", now=MORNING)
    begin_sitting(study, ledger, "A", now=MORNING)
    finish(ledger, "A")
    assert begin_sitting(study, ledger, "A", now=MORNING + timedelta(hours=24)).sitting == 1


def test_an_unknown_code_and_a_finished_participant_cannot_begin(study, ledger):
    with pytest.raises(NotNow, match="nobody with the code X"):
        begin_sitting(study, ledger, "X")
    enrol(study, ledger, "A", now=MORNING)
    begin_sitting(study, ledger, "A", now=MORNING)
    finish(ledger, "A")
    with pytest.raises(NotNow, match="has finished"):
        begin_sitting(study, ledger, "A", now=MORNING)


def test_a_folder_of_another_study_or_seed_is_refused(tmp_path, study):
    Ledger(tmp_path, study=study.name, seed=study.seed)
    with pytest.raises(LedgerError, match="keeps its name and its seed"):
        Ledger(tmp_path, study=study.name, seed=study.seed + 1)


def test_a_changed_line_is_named(study, ledger):
    enrol(study, ledger, "A", now=MORNING)
    ledger.path.write_bytes(ledger.path.read_bytes().replace(b'"place":0', b'"place":7'))
    with pytest.raises(LedgerError, match=r"ledger\.jsonl:2: this line was changed"):
        ledger.lines()


@pytest.mark.parametrize(
    "line",
    [
        SittingStarted(code="P99", sitting=0, attempt=0),
        StepDone(code="A", sitting=3, step=0),
        SittingEnded(code="P99", sitting=0, how="finished"),
        DroppedOut(code="P99", reason="none"),
    ],
)
def test_a_line_of_nobody_is_named(study, ledger, line):
    enrol(study, ledger, "A", now=MORNING)
    ledger.append(line)
    with pytest.raises(LedgerError, match=rf"ledger\.jsonl:\d: .* of {line.code}: no line before enrols"):
        progress(ledger.lines())


def test_a_line_cut_off_by_a_kill_is_removed_by_the_next_writer(study, ledger):
    enrol(study, ledger, "A", now=MORNING)
    with ledger.path.open("ab") as file:
        file.write(b'{"type":"enrolled","code":"B"')
    ledger.append(Declined())
    assert [type(line).__name__ for line in ledger.lines()] == ["Opened", "Enrolled", "Declined"]


def test_withdrawing_leaves_no_code_in_the_ledger_and_keeps_the_balance(study, ledger):
    enrol(study, ledger, "SECRET", now=MORNING)
    enrol(study, ledger, "B", now=MORNING)
    ledger.replace_code("SECRET", "withdrawn-1", last=Withdrawn(code="withdrawn-1", files_removed=3))
    everything = b"".join(p.read_bytes() + p.name.encode() for p in ledger.folder.rglob("*") if p.is_file())
    assert b"SECRET" not in everything
    assert progress(ledger.lines()).participants["withdrawn-1"].order == order_of(study, 0)
    assert enrol(study, ledger, "C", now=MORNING).place == 0


def test_only_the_owner_can_read_the_ledger(study, ledger):
    enrol(study, ledger, "A", now=MORNING)
    for path in (ledger.folder, *ledger.folder.rglob("*")):
        assert path.stat().st_mode & 0o077 == 0


def test_nobody_goes_on_under_a_study_file_that_lost_their_condition_or_blocks(study, ledger):
    enrol(study, ledger, "A", now=MORNING)
    other = msgspec.structs.replace(study, conditions={"c0": study.conditions["c0"], "new": {}})
    with pytest.raises(NotNow, match=r"A was enrolled with the order .*has no condition 'c1', only c0, new"):
        begin_sitting(other, ledger, "A", now=MORNING)
    with pytest.raises(NotNow, match="has 3 blocks with an assigned condition, not 2"):
        begin_sitting(study_of(conditions=3), ledger, "A", now=MORNING)
    assert begin_sitting(study, ledger, "A", now=MORNING).number == 0


def test_a_missing_or_empty_ledger_is_not_begun_anew_beside_participants(study, ledger):
    participant_folder(ledger.folder, "A").mkdir(parents=True)
    for lose in (ledger.path.write_bytes, lambda _: ledger.path.unlink()):
        lose(b"")
        with pytest.raises(LedgerError, match=r"files of 1 participant: .*Take the newest copy"):
            Ledger(ledger.folder, study=study.name, seed=study.seed)
    participant_folder(ledger.folder, "A").rmdir()
    assert Ledger(ledger.folder, study=study.name, seed=study.seed).lines()


@pytest.mark.parametrize("code", ["", ".", "..", "../B", "a/../B", "/tmp"])
def test_no_code_names_a_folder_elsewhere(tmp_path, code):
    with pytest.raises(ValueError, match="is no participant's code"):
        participant_folder(tmp_path, code)
