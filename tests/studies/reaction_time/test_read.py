import gzip
from pathlib import Path

import numpy as np
import pytest

from core.numerics.streams import stream
from studies.reaction_time.exclusion import ExclusionPolicy, Row, judge, select
from studies.reaction_time.fit import FitSettings, fit_participant
from studies.reaction_time.read import BIDS, Columns, ReadError, read_rows, read_table, write_rows
from studies.reaction_time.trial_log import TrialWriter
from tests.data_folder import data_files, data_folder
from tests.studies.reaction_time import real
from tests.studies.reaction_time.test_trial_log import HEADER, played

GO = Columns(rt="ReactionTime", unit="s", keep={"TrialOutcome": ("SuccessfulGo",)})


def write(folder: Path, name: str, *lines: str) -> Path:
    path = folder / name
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def test_real_go_reactions_are_read_as_plain_csv_reads_them():
    rows = read_table(data_folder("reaction_time") / "stop_signal_ds000030_events.tsv.gz", GO)
    assert len(rows) == 24_117
    samples, selection = select(rows, ExclusionPolicy())
    expected = real.go_times()
    assert list(samples) == list(expected)
    assert all(np.array_equal(samples[p].observed_s, expected[p]) for p in expected)
    assert sum(counts.get("anticipation", 0) for counts in selection.counts.values()) == 6


def test_real_flanker_reactions_need_no_unit_because_bids_fixes_it():
    columns = Columns(rt="response_time", keep={"correctness": ("correct",)})
    rows = read_table(data_folder("reaction_time") / "flanker_ds000102_events.tsv.gz", columns)
    samples, _ = select(rows, ExclusionPolicy())
    assert {p: s.n for p, s in samples.items()} == {p: x.size for p, x in real.flanker_times().items()}


@pytest.mark.parametrize("path", data_files("reaction_time", pattern="*.tsv.gz"), ids=lambda path: path.name)
def test_every_row_of_every_real_table_gets_a_verdict(path):
    with gzip.open(path, "rt") as file:
        header = file.readline().rstrip("\n").split("\t")
    rt = next(name for name in ("response_time", "ReactionTime") if name in header)
    rows = read_table(path, Columns(rt=rt, unit="s"))
    _, selection = select(rows, ExclusionPolicy())
    assert len(selection.verdicts) == len(rows)
    assert sum(sum(counts.values()) for counts in selection.counts.values()) == len(rows)


def test_our_own_recordings_are_read_with_status_practice_and_waiting_time(tmp_path):
    path = tmp_path / "P01.jsonl"
    with TrialWriter.create(path, HEADER) as writer:
        for index in range(6):
            writer.write(played(index, 300 + index if index != 4 else 50))
    rows = read_rows([path])
    samples, selection = select(rows, ExclusionPolicy())
    assert selection.verdicts == ("practice", "practice", "kept", "kept", "anticipation", "kept")
    assert list(selection.unusable) == ["P01"]
    assert "3 usable responses" in selection.unusable["P01"]
    assert samples == {}
    assert rows[2].rt_s == pytest.approx(0.302)


@pytest.mark.parametrize(
    ("name", "header", "expected"),
    [
        ("a.csv", "participant_id,rt_ms", 0.4),
        ("a.csv", "participant_id,RT (ms)", 0.4),
        ("a.csv", "participant_id;latency_msec", 0.4),
        ("a.tsv", "participant_id\trt_us", 0.0004),
    ],
)
def test_the_unit_may_be_in_the_columns_name(tmp_path, name, header, expected):
    delimiter = next(sign for sign in "\t;," if sign in header)
    path = write(tmp_path, name, header, *[f"p{delimiter}400"] * 6)
    columns = Columns(rt=header.split(delimiter)[1], trust_magnitudes=True)
    assert read_table(path, columns)[0].rt_s == pytest.approx(expected)


def test_the_unit_may_be_in_the_sidecar(tmp_path):
    path = write(tmp_path, "sub-07_task-x_beh.tsv", "latency", "400", "500", "450")
    write(tmp_path, "sub-07_task-x_beh.json", '{"latency": {"Units": "ms"}}')
    rows = read_table(path, Columns(rt="latency"))
    assert [row.rt_s for row in rows] == pytest.approx([0.4, 0.5, 0.45])
    assert {row.participant for row in rows} == {"sub-07"}


def test_a_column_without_a_unit_is_an_error_that_says_how_to_state_one(tmp_path):
    path = write(tmp_path, "a.csv", "participant_id,latency", "p,0.4")
    with pytest.raises(ReadError, match=r"'latency' has no unit.*unit='s' or unit='ms'.*latency_ms"):
        read_table(path, Columns(rt="latency"))
    with pytest.raises(ReadError, match="has no unit"):  # BIDS's rule is for BIDS's files
        read_table(write(tmp_path, "b.csv", "response_time", "0.4"), BIDS)


@pytest.mark.parametrize(
    ("unit", "values", "advice"),
    [
        ("s", [412, 530, 388, 467, 502], "unit='ms'"),
        ("ms", [0.412, 0.53, 0.388, 0.467, 0.502], "unit='s'"),
        ("s", [412e3, 530e3, 388e3, 467e3, 502e3], "unit='us'"),
        ("s", [1e-9] * 5, "no unit makes reactions"),
    ],
)
def test_times_in_another_unit_than_stated_are_refused_with_the_likely_unit(tmp_path, unit, values, advice):
    path = write(tmp_path, "a.csv", "participant_id,rt", *[f"p,{value}" for value in values])
    with pytest.raises(ReadError, match=advice):
        read_table(path, Columns(rt="rt", unit=unit))
    assert len(read_table(path, Columns(rt="rt", unit=unit, trust_magnitudes=True))) == 5


def test_one_participant_in_another_unit_is_found_among_many(tmp_path):
    lines = [f"p{i},0.4" for i in range(9) for _ in range(6)] + ["odd,400"] * 6
    path = write(tmp_path, "a.csv", "participant_id,rt_s", *lines)
    with pytest.raises(ReadError, match=r"median of 400 s for 'odd'"):
        read_table(path, Columns(rt="rt_s"))


def test_dirty_rows_are_read_judged_counted_and_not_deleted(tmp_path):
    dirty = ["n/a", "", "NaN", "0", "-0.3", "1e6", "0.004", "7.5", "inf", "-inf", "None"]
    good = [repr(float(t)) for t in 0.2 + stream(1, "dirty").gamma(4.0, 0.07, 30)]
    path = write(tmp_path, "a.csv", "participant_id,rt_s", *[f"p,{cell}" for cell in dirty + good])
    rows = read_table(path, Columns(rt="rt_s"))
    samples, selection = select(rows, ExclusionPolicy())
    assert len(rows) == len(dirty) + len(good)
    assert selection.verdicts[: len(dirty)] == (
        "missing",
        "missing",
        "missing",
        "no response",
        "negative",
        "absurd",
        "anticipation",
        "slow",
        "missing",
        "missing",
        "missing",
    )
    assert selection.counts["p"]["kept"] == 30
    assert rows[4].rt_s == -0.3
    out = tmp_path / "judged.tsv"
    write_rows(out, rows, selection.verdicts)
    assert out.read_text().count("\n") == len(rows) + 1
    assert "-0.3\tok\tnegative" in out.read_text()
    clean = fit_participant("p", samples["p"], FitSettings(families=("gamma",), n_resamples=0))
    assert clean.gamma.n_observed == 30


def test_no_response_is_censored_only_where_the_waiting_time_is_known(tmp_path):
    path = write(tmp_path, "a.csv", "participant_id,rt_s", *["p,0.4", "p,0.5"] * 5, "p,0", "p,0")
    known, _ = select(read_table(path, Columns(rt="rt_s", waited_s=1.5)), ExclusionPolicy())
    assert known["p"].censored_s.tolist() == [1.5, 1.5]
    unknown, selection = select(read_table(path, Columns(rt="rt_s")), ExclusionPolicy())
    assert unknown["p"].censored_s.size == 0
    assert selection.counts["p"]["no response"] == 2
    left_out, _ = select(
        read_table(path, Columns(rt="rt_s", waited_s=1.5)), ExclusionPolicy(time_outs="exclude")
    )
    assert left_out["p"].censored_s.size == 0


@pytest.mark.parametrize(
    ("fields", "verdict"),
    [
        ({"rt_s": 0.4}, "kept"),
        ({"rt_s": 0.1}, "kept"),
        ({"rt_s": 3.0}, "kept"),
        ({"rt_s": 0.4, "status": "wrong key"}, "wrong key"),
        ({"rt_s": 0.4, "status": "repeat"}, "repeat"),
        ({"rt_s": 0.05, "status": "anticipation"}, "anticipation"),
        ({"rt_s": None, "status": "time-out", "waited_s": 2.0}, "timed out"),
        ({"rt_s": None, "status": "time-out"}, "no response"),
        ({"rt_s": None}, "missing"),
        ({"rt_s": None, "response_asked": False}, "catch"),
        ({"rt_s": 0.4, "practice": True}, "practice"),
        ({"rt_s": 0.4, "abandoned": True}, "abandoned"),
    ],
)
def test_a_policy_judges_each_row_by_itself(fields, verdict):
    assert judge(Row(participant="p", source="x:1", **fields), ExclusionPolicy()) == verdict


def test_practice_may_be_kept_on_purpose():
    row = Row(participant="p", source="x:1", rt_s=0.4, practice=True)
    assert judge(row, ExclusionPolicy(keep_practice=True)) == "kept"


def test_a_policy_whose_limits_cross_is_refused():
    with pytest.raises(ValueError, match="anticipation_below_s < slow_above_s"):
        ExclusionPolicy(anticipation_below_s=4.0)


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        (["participant_id,rt_s", "p,0,4"], r":2: 3 cells"),
        (["participant_id;rt_s", "p;0,4"], r"'0,4', not a number; if that is a decimal comma"),
        (["participant_id,rt_s", "p,fast"], r":2: column 'rt_s' holds 'fast'"),
        (["participant_id,time", "p,0.4"], r"no column 'rt_s'; the columns are 'participant_id', 'time'"),
        (["participant_id,rt_s,rt_s", "p,1,2"], "same name"),
        (["participant_id,rt_s", ",0.4"], r":2: no participant"),
        (["participant_id,rt_s"], "no row left"),
        ([""], "empty"),
    ],
)
def test_a_table_that_cannot_be_understood_says_where_and_what_to_do(tmp_path, lines, message):
    with pytest.raises(ReadError, match=message):
        read_table(write(tmp_path, "a.csv", *lines), Columns(rt="rt_s"))


def test_rows_that_no_filter_lets_through_are_an_error(tmp_path):
    path = write(tmp_path, "a.csv", "participant_id,rt_s,ok", "p,0.4,no")
    with pytest.raises(ReadError, match="no row left"):
        read_table(path, Columns(rt="rt_s", keep={"ok": ("yes",)}))


def test_a_damaged_gzip_file_is_named(tmp_path):
    path = tmp_path / "a.tsv.gz"
    path.write_bytes(gzip.compress(b"rt_s\n0.4\n")[:-6])
    with pytest.raises(ReadError, match=r"a\.tsv\.gz: cannot be read"):
        read_table(path, Columns(rt="rt_s"))


def test_a_byte_order_mark_quotes_and_windows_line_ends_do_no_harm(tmp_path):
    path = tmp_path / "a.csv"
    path.write_bytes("﻿".encode() + b'"participant_id","rt_s"\r\n"p, one","0.4"\r\n\r\n"p, one","0.5"\r\n')
    rows = read_table(path, Columns(rt="rt_s"))
    assert [(row.participant, row.rt_s) for row in rows] == [("p, one", 0.4), ("p, one", 0.5)]
    assert rows[1].source == "a.csv:4"


def test_something_that_is_no_recording_of_ours_is_an_error(tmp_path):
    with pytest.raises(ReadError, match="not a header"):
        read_rows([write(tmp_path, "a.jsonl", "{}")])


@pytest.mark.parametrize("name", ["rtMs", "RT.ms", "rt-ms", "RT (ms)", "RT [msec]"])
def test_a_unit_is_found_however_it_is_joined_to_the_columns_name(tmp_path, name):
    path = tmp_path / "a.csv"
    path.write_text(f"{name}\n" + "".join(f"{v}\n" for v in range(300, 340)))
    assert read_rows([path], Columns(rt=name))[0].rt_s == pytest.approx(0.3)


def test_utf_16_spaces_before_quotes_and_cells_left_empty_at_the_end_do_no_harm(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text('"who" , "rt_s"\n "P1" , 0.30 ,\n "P1" ,0.40,,\n', encoding="utf-16")
    rows = read_rows([path], Columns(rt="rt_s", participant="who"))
    assert [(row.participant, row.rt_s) for row in rows] == [("P1", 0.3), ("P1", 0.4)]
    path.write_text("who,rt_s\nP1,0.30,7\n")
    with pytest.raises(ReadError, match="3 cells in a row, 2 columns"):
        read_rows([path], Columns(rt="rt_s", participant="who"))


def test_a_file_that_ends_inside_a_line_is_read_where_no_earlier_row_has_a_time(tmp_path):
    path = tmp_path / "one.csv"
    path.write_text("subject;latency ms\nP1;\nP1;510")  # found by a fuzzer
    rows = read_table(path, Columns(rt="latency ms", participant="subject"))
    assert [row.rt_s for row in rows] == [None, 0.51]


def test_a_row_of_nobody_is_refused(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("who,rt_s\nP1,0.30\nn/a,0.4\n")
    with pytest.raises(ReadError, match=r"a\.csv:3: no participant in column 'who', but 'n/a'"):
        read_rows([path], Columns(rt="rt_s", participant="who"))
