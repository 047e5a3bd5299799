"""Files of other programs: recognised by marks, each with its way of saying late, wrong, practice."""

import csv
from collections import Counter
from pathlib import Path

import pytest

from studies.reaction_time.exclusion import ExclusionPolicy, select
from studies.reaction_time.read import Columns, ReadError, Reading, read_files
from studies.reaction_time.tables.registry import PRESETS
from tests.data_folder import data_root
from tests.studies.reaction_time import program_files
from tests.studies.reaction_time.program_files import FILES, made

ANY = Columns(trust_magnitudes=True)


def read(path: Path, columns: Columns = ANY, preset: str | None = None) -> Reading:
    (reading,) = read_files([path], columns, preset)
    return reading


def verdicts(reading: Reading) -> list[str]:
    return list(select(reading.rows, ExclusionPolicy())[1].verdicts)


def test_there_is_a_file_for_each_preset():
    assert sorted(FILES) == sorted(preset.name for preset in PRESETS)


@pytest.mark.parametrize("name", FILES)
def test_a_file_is_recognised_and_read_the_same_with_and_without_the_presets_name(tmp_path, name):
    path = made(tmp_path, name)
    assert read(path) == read(path, preset=name)
    title = next(preset.title for preset in PRESETS if preset.name == name)
    assert read(path).recognised.startswith(title)


@pytest.mark.parametrize("name", FILES)
def test_every_row_is_taken_or_counted_with_a_reason(tmp_path, name):
    reading = read(made(tmp_path, name))
    assert reading.taken.total() == len(reading.rows) > 0
    assert all(n > 0 for n in reading.left_out.values())


@pytest.mark.parametrize("name", FILES)
@pytest.mark.parametrize("other", FILES)
def test_a_preset_that_does_not_fit_is_an_error_that_names_the_one_that_does(tmp_path, name, other):
    if name != other:
        with pytest.raises(ReadError, match=rf"this is no file of .*--from {name}"):
            read(made(tmp_path, name), preset=other)


def test_an_unknown_preset_is_an_error_with_the_known_ones(tmp_path):
    with pytest.raises(
        ReadError, match=r"no preset is called 'gorila'; there are psychopy, .*gorilla.* table"
    ):
        read(made(tmp_path, "gorilla"), preset="gorila")


def test_psychopy_takes_the_trials_of_loops_and_knows_no_go_practice_and_wrong_keys(tmp_path):
    reading = read(made(tmp_path, "psychopy"))
    assert [row.rt_s for row in reading.rows] == [0.61, 0.41, 0.52, None, None]
    assert verdicts(reading) == ["practice", "kept", "wrong key", "no response", "catch"]
    assert {row.participant for row in reading.rows} == {"7"}
    assert reading.left_out == {
        "outside the loops of trials (instructions, end of the session)": 1,
        "another routine's: 'resp' was not on": 1,
    }


def test_psychopys_lists_of_times_are_refused_until_it_is_said_which_counts(tmp_path):
    path = made(tmp_path, "psychopy")
    path.write_text(
        path.read_text(encoding="utf-8").replace("1,0.41,", '1,"[0.41, 0.87]",'), encoding="utf-8"
    )
    with pytest.raises(ReadError, match=r":4: column 'resp.rt' holds a list of 2 times.*--list first"):
        read(path)
    assert read(path, Columns(of_list="first")).rows[1].rt_s == 0.41
    assert read(path, Columns(of_list="last")).rows[1].rt_s == 0.87


def test_two_keyboards_with_as_many_times_are_not_chosen_between(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("psychopyVersion,trials.thisN,a.keys,a.rt,b.keys,b.rt\n" + "1,0,x,0.4,y,0.6\n" * 5)
    with pytest.raises(
        ReadError, match=r"several kinds, 'a.rt' \(5 times\), 'b.rt' \(5 times\).*--column rt="
    ):
        read(path)
    assert read(path, Columns(rt="b.rt"), "psychopy").rows[0].rt_s == 0.6


def test_gorillas_first_builder_is_read_by_zones_time_outs_and_attempts(tmp_path):
    reading = read(made(tmp_path, "gorilla"))
    assert verdicts(reading) == ["wrong key", "timed out", "practice", "kept"]
    assert [row.rt_s for row in reading.rows] == pytest.approx([0.4125, None, 0.5015, 0.38825])
    assert reading.rows[1].waited_s == pytest.approx(3.0002)
    assert reading.left_out["later attempts at the same trial"] == 1
    assert reading.left_out["Gorilla's END OF FILE"] == 1


def test_opensesames_none_is_a_time_out_and_a_response_logged_twice_counts_once(tmp_path):
    reading = read(made(tmp_path, "opensesame"), Columns(rt="response_time_key"), "opensesame")
    assert verdicts(reading) == ["practice", "kept", "wrong key", "timed out"]
    assert reading.rows[3].waited_s == pytest.approx(2.0004)
    assert reading.left_out.total() == 2
    assert read(made(tmp_path, "opensesame")).rows == reading.rows


def test_dmdx_negative_times_are_errors_and_the_longest_that_come_twice_time_outs(tmp_path):
    reading = read(made(tmp_path, "dmdx"))
    assert [row.participant for row in reading.rows] == ["1", "1", "1", "anna7", "anna7"]
    assert [row.rt_s for row in reading.rows] == pytest.approx([0.54321, 0.6124, None, 0.42321, None])
    assert verdicts(reading) == ["kept", "wrong key", "timed out", "kept", "timed out"]
    assert any("taken as time-outs of 2.5 s" in note for note in reading.notes)


def test_qualtrics_rows_become_one_per_person_and_question_without_headers_and_previews(tmp_path):
    reading = read(made(tmp_path, "qualtrics"))
    assert [(row.participant, row.rt_s) for row in reading.rows] == [
        ("R_1abc", 0.812),
        ("R_1abc", None),
        ("R_2def", 1.012),
    ]
    assert reading.left_out == {
        "Qualtrics' further header rows": 2,
        "questions that were not shown": 1,
        "previews and spam (Status)": 2,
    }
    submitted = read(made(tmp_path, "qualtrics"), Columns(rt="Page Submit"), "qualtrics")
    assert [row.rt_s for row in submitted.rows] == [2.25, 3.5, 2.75]


def test_jspsych_fixations_are_told_from_trials_without_a_response(tmp_path):
    reading = read(made(tmp_path, "jspsych"))
    assert verdicts(reading) == ["kept", "no response"]
    assert reading.left_out["stimuli that come often and never have a response (fixations)"] == 3
    assert reading.left_out["trial_type 'survey-text': measures no reaction"] == 1


def test_several_jspsych_sessions_in_one_file_are_different_people(tmp_path):
    path = tmp_path / "jatos.txt"
    path.write_text(program_files.JSPSYCH + "\n" + program_files.JSPSYCH + "\n", encoding="utf-8")
    assert {row.participant for row in read(path).rows} == {"1", "2"}
    path.write_text(program_files.JSPSYCH[:-30], encoding="utf-8")
    with pytest.raises(ReadError, match=r"jatos.txt:1: not whole JSON"):
        read(path)


def test_eprimes_log_knows_the_block_of_each_trial_and_where_a_crash_cut_it(tmp_path):
    path = made(tmp_path, "eprime")
    reading = read(path)
    assert verdicts(reading) == ["practice", "no response", "catch", "wrong key"]
    assert {row.participant for row in reading.rows} == {"21"}
    text = program_files.EPRIME_LOG
    cut = text[: text.index("Stim.RT: 512")]
    path.write_text(cut, encoding="utf-16")
    crashed = read(path)
    assert len(crashed.rows) == 3
    assert crashed.left_out["cut off in writing"] == 1
    assert f"line {cut[: cut.rindex('*** LogFrame Start')].count(chr(10)) + 1}" in crashed.notes[0]


def test_eprimes_merged_export_is_read_behind_its_path(tmp_path):
    path = tmp_path / "merged.txt"
    path.write_text(program_files.EPRIME_MERGED, encoding="utf-16")
    reading = read(path)
    assert verdicts(reading) == ["kept", "wrong key", "no response"]
    assert "all.emrg3" in reading.notes[0]


def test_answers_are_not_called_wrong_where_none_is_ever_right(tmp_path):
    path = tmp_path / "merged.txt"
    path.write_text(program_files.EPRIME_MERGED.replace("\t1\t1\t1\t401", "\t0\t\t1\t401"))
    reading = read(path)
    assert verdicts(reading)[:2] == ["kept", "kept"]
    assert any("calls no answer right" in note for note in reading.notes)


def test_a_named_column_reads_a_programs_file_as_a_table_and_says_so(tmp_path):
    reading = read(
        made(tmp_path, "opensesame"), Columns(rt="response_time_key", unit="ms", participant="subject_nr")
    )
    assert len(reading.rows) == 6
    assert "--from opensesame" in reading.notes[0]


# --- files made for these programs by others ----------------------------------------------------------------

CASES = data_root().parent / "cases"


def case(*parts: str) -> Path:
    path = CASES.joinpath(*parts)
    if not path.exists():
        pytest.skip(f"no input cases at {path}")
    return path


def test_gorillas_case_holds_what_plain_csv_counts_in_it():
    path = case("gorilla", "data_exp_99182-v7_task-xk2d.csv")
    with path.open(encoding="utf-8-sig", newline="") as file:
        kinds = Counter(row["Response Type"] for row in csv.DictReader(file))
    taken = Counter(read(path).taken)
    assert taken["responses"] + taken["responses (practice)"] == kinds["response"] == 68
    assert (taken["too early"], taken["without a response"]) == (kinds["too early"], kinds["timed out"])


def test_jspsychs_csv_and_json_cases_are_the_same_data():
    of_csv, of_json = (read(case("jspsych", f"data_s4f9.{end}")) for end in ("csv", "json"))
    assert [row.rt_s for row in of_csv.rows] == [row.rt_s for row in of_json.rows]
    assert of_csv.taken == of_json.taken == {"responses": 47, "wrong answers": 2, "without a response": 1}


def test_psychopys_and_eprimes_cases_are_read():
    assert read(case("psychopy", "P07_stroop_2026-03-04_10h12.33.517.csv")).taken["responses"] == 58
    assert {row.participant for row in read(case("eprime", "merged_export.txt")).rows} == {"3", "4", "11"}
    assert read(case("eprime", "simpleRT-21-1_crashed.txt")).left_out["cut off in writing"] == 1
    with pytest.raises(ReadError, match="holds a list of 2 times"):
        read(case("psychopy", "lists", "P09_stroop_2026-03-04_14h05.51.902.csv"))


# --- variants of the formats --------------------------------------------------------------------------------


def test_psychojs_leaves_the_keys_of_a_missed_trial_empty(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text(
        "expName,trials.thisN,resp.keys,resp.corr,resp.rt\nx,0,f,1,0.4\nx,1,,0,\nx,2,f,1,[0.5]\nx,3,,,\n"
    )
    reading = read(path)
    assert verdicts(reading) == ["kept", "no response", "kept"]  # a list of one time is that time
    assert reading.left_out.total() == 1


def test_e_primes_path_may_hold_another_separator_than_the_table(tmp_path):
    path = tmp_path / "merged.txt"
    path.write_text(
        program_files.EPRIME_MERGED.replace("D:\\Lab\\all", "D:\\Lab, old; 2,0\\all"), encoding="utf-16"
    )
    assert len(read(path).rows) == 3


def test_old_jspsych_says_minus_one_and_a_plugin_of_ones_own_is_read(tmp_path):
    path = tmp_path / "a.csv"
    head = "rt,key_press,trial_type,trial_index,internal_node_id,name\n"
    rts = [401, -1, 377]
    path.write_text(head + "".join(f"{rt},70,my-own-task,{i},0.0-{i},word{i}\n" for i, rt in enumerate(rts)))
    assert verdicts(read(path)) == ["kept", "no response", "kept"]


def test_opensesame_in_the_browser_has_no_answer_where_it_timed_out(tmp_path):
    path = tmp_path / "a.csv"
    head = "subject_nr,opensesame_version,response,response_time,correct\n"
    path.write_text(head + "4,4.0,z,402,1\n4,4.0,,2000,0\n")
    assert verdicts(read(path)) == ["kept", "timed out"]


def test_a_code_for_no_response_can_be_stated(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("participant_id,rt_ms\n" + "P,431\nP,-1\nP,402\nP,9999\n")
    reading = read(path, Columns(rt="rt_ms", missing=("-1", "9999"), waited_s=2.0))
    assert verdicts(reading) == ["kept", "timed out", "kept", "timed out"]
    assert reading.taken == {"rows": 2, "without a response": 2}


def test_a_clock_that_begins_anew_with_each_block_is_still_a_clock(tmp_path):
    path = tmp_path / "a.csv"
    rows = "".join(f"P,{(i % 15) * 1.7 + 2:.2f}\n" for i in range(30))
    path.write_text("participant_id,rt_s\n" + rows)
    with pytest.raises(ReadError, match="it holds times on a clock"):
        read(path, Columns(rt="rt_s"))


def test_a_preset_that_is_asked_for_is_not_overlooked_for_a_recordings_name(tmp_path):
    path = tmp_path / "a.jsonl"
    path.write_text(program_files.JSPSYCH + "\n", encoding="utf-8")
    assert len(read(path, preset="jspsych").rows) == 2
    with pytest.raises(ReadError, match="this is no file of Gorilla"):
        read(path, preset="gorilla")
