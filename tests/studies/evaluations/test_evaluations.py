"""Tables of evaluations as recordings: presses with delays and bursts, nothing lost, nothing to replay."""

from pathlib import Path

import pytest

from core.events import FrameShown, KeyPressed
from core.recording.importers.contract import (
    BUILT_IN,
    Importer,
    ImporterError,
    checked_settings,
    importer_names,
    load_importer,
)
from core.recording.reader import read_recording
from core.recording.summary import summarise_recording
from studies.evaluations.importer import IMPORTER
from studies.evaluations.presses import presses_of, report_lines
from studies.reaction_time.read import ReadError, read_files
from studies.session_view.comparison import NothingToCompareError, figures_of
from tests.data_folder import REPOSITORY, data_folder

TABLE = """participant_id,task,time_s,value,delay_s
E1,a,1725473969.956141,1,0.9
E1,a,1725473970.156141,1,
E1,a,1725473999.000000,-2,0.75
E1,b,10.5,0,1.5
E2,a,3.0,2,0.5
E2,a,2.0,,0.5
E2,a,2.5,-1,-0.1
"""


def imported(folder: Path, text: str = TABLE, **settings: str):
    path = folder / "table.csv"
    path.write_text(text, encoding="utf-8")
    return IMPORTER.run(path, folder / "out", {"by": "task", **settings})


def test_each_participant_and_task_becomes_a_recording_that_begins_at_0(tmp_path):
    made = imported(tmp_path)
    assert [path.name for path in made.recordings] == ["E1-a.jsonl", "E1-b.jsonl", "E2-a.jsonl"]
    recording = read_recording(made.recordings[0], allow_truncated=False)
    assert recording.header.source["condition task"] == "a"
    presses = [event for event in recording.events if isinstance(event, KeyPressed)]
    frames = [event for event in recording.events if isinstance(event, FrameShown)]
    assert frames[0].flushed_ns == 0
    # Microseconds of seconds since 1970 are kept exactly.
    assert [press.time_ns for press in presses] == [900_000_000, 1_100_000_000, 29_943_859_000]
    assert [press.value for press in presses] == [1.0, 1.0, -2.0]
    times = [e.time_ns if isinstance(e, KeyPressed) else e.flushed_ns for e in (*frames, *presses)]
    assert min(times) == 0


def test_a_recording_without_a_game_is_not_said_to_be_of_one(tmp_path):
    (path, *_) = imported(tmp_path).recordings
    words = summarise_recording(read_recording(path)).words
    assert words == "evaluations without their game; 3 presses counted; ended: imported"
    with pytest.raises(NothingToCompareError, match="imported evaluations without their games"):
        figures_of(path)


def test_a_column_of_moments_is_proposed(tmp_path):
    with pytest.raises(ImporterError, match=r"no column 'time_s'.*likely is 'stamp_unix_s'"):
        imported(tmp_path, TABLE.replace("time_s", "stamp_unix_s"))


def test_delays_come_back_as_they_were_and_presses_without_one_are_kept(tmp_path):
    made = imported(tmp_path)
    delays = [press.delay_s for path in made.recordings for press in presses_of(read_recording(path))]
    assert delays == pytest.approx([0.9, None, 0.75, 1.5, -0.1, 0.5])
    words = "\n".join(made.lines)
    assert "6 evaluations of 2 participants in 3 recordings" in words
    assert "1 of them without a delay" in words
    assert "1 came before the event" in words
    assert "left out: 1 rows, without a value" in words


def test_bursts_join_presses_of_one_sign_only(tmp_path):
    rows = "".join(f"E,{time},{value}\n" for time, value in [(0, 1), (0.2, 2), (0.4, -1), (0.6, -1), (5, -1)])
    made = imported(tmp_path, "participant_id,time_s,value\n" + rows, by="")
    presses = presses_of(read_recording(made.recordings[0]))
    assert [press.burst for press in presses] == [0, 0, 1, 1, 2]
    assert report_lines(presses, delays_of_what="x")[0].startswith(
        "5 presses in 3 bursts (2 of more than one press, 0.20 s"
    )
    assert any("no column of delays" in line for line in made.lines)


def test_delays_of_imported_evaluations_are_fitted_like_reaction_times(tmp_path):
    made = imported(tmp_path)
    readings = read_files(made.recordings)
    assert [row.rt_s for reading in readings for row in reading.rows] == pytest.approx(
        [0.9, None, 0.75, 1.5, -0.1, 0.5]
    )
    assert readings[2].rows[0].status == "anticipation"


def test_a_live_sessions_presses_are_not_called_delays():
    found = REPOSITORY / "recordings" / "reference" / "tetris-linear-equation-4.jsonl"
    with pytest.raises(ReadError, match="what each press judged is not known"):
        read_files([found])


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("E1,b,10.5,0", "../../etc/passwd,b,10.5,0"), r"table.csv:5: the participant is '../../etc/passwd'"),
        (("E1,b,10.5", "E1,b,soon"), r"table.csv:5: column 'time_s' holds 'soon'"),
        (("E1,b,10.5", "E1,b,1e40"), r"table.csv:5: column 'time_s' holds '1e40'"),
        (("10.5,0", "10.5,good"), r"table.csv:5: column 'value' holds 'good', not a number"),
        (("time_s", "when"), r"no column 'time_s'.*--column time=NAME"),
        (("delay_s", "lag"), None),
    ],
)
def test_a_table_that_cannot_be_understood_says_where_and_leaves_nothing_behind(tmp_path, change, words):
    text = TABLE.replace(*change)
    if words is None:
        assert any("no column of delays" in line for line in imported(tmp_path, text).lines)
        return
    with pytest.raises(ImporterError, match=words):
        imported(tmp_path, text)
    assert not (tmp_path / "out").exists()


def test_a_unit_is_stated_or_in_the_name_and_recordings_are_never_overwritten(tmp_path):
    with pytest.raises(ImporterError, match="'when' has no unit"):
        imported(tmp_path, TABLE.replace("time_s", "when"), time="when")
    imported(tmp_path)
    with pytest.raises(FileExistsError, match="never overwritten"):
        imported(tmp_path)


def test_the_programs_importers_keep_the_contract_and_others_are_found_by_their_entry_point(monkeypatch):
    for name in BUILT_IN:
        importer = load_importer(name)
        assert isinstance(importer, Importer)
        assert importer.name == name
    with pytest.raises(
        ImporterError, match="no importer is called 'nobody'; there are tamer-log, evaluations"
    ):
        load_importer("nobody")
    with pytest.raises(ImporterError, match="evaluations has no setting 'units'"):
        checked_settings(IMPORTER, {"units": "s"})
    from importlib.metadata import EntryPoint

    from core.recording.importers import contract

    points = [EntryPoint("our-lab", "studies.evaluations.importer:IMPORTER", contract.GROUP)]
    monkeypatch.setattr(contract, "entry_points", lambda group: points)
    assert importer_names()["our-lab"] == "studies.evaluations.importer:IMPORTER"
    assert load_importer("our-lab") is IMPORTER
    points.append(EntryPoint("evaluations", "elsewhere:X", contract.GROUP))
    with pytest.raises(ImporterError, match="two importers are called 'evaluations'"):
        importer_names()
    points[:] = [EntryPoint("broken", "nowhere.at.all:X", contract.GROUP)]
    with pytest.raises(ImporterError, match="cannot be loaded"):
        load_importer("broken")
    points[:] = [EntryPoint("wrong", "pathlib:Path", contract.GROUP)]
    with pytest.raises(ImporterError, match="is no importer"):
        load_importer("wrong")


def test_real_evaluations_keep_every_value_and_delay(tmp_path):
    source = data_folder("evaluation_delays") / "charm.csv"
    settings = {"participant": "participant", "time": "stamp_unix_s", "by": "set,task,agent"}
    head = source.read_text().splitlines()[:400]
    path = tmp_path / "charm.csv"
    path.write_text("\n".join(head) + "\n")
    made = IMPORTER.run(path, tmp_path / "out", settings)
    found = sorted(
        (press.participant, press.value, round(press.delay_s or 0, 6))
        for recording in made.recordings
        for press in presses_of(read_recording(recording))
    )
    rows = [dict(zip(head[0].split(","), line.split(","), strict=True)) for line in head[1:]]
    assert found == sorted((r["participant"], float(r["value"]), round(float(r["delay_s"]), 6)) for r in rows)
