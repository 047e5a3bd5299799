"""Tables as spreadsheets, statistics packages, crashes and `cat` leave them: read, or named with the line."""

import gzip
import subprocess
import sys
import zlib
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from studies.reaction_time.read import Columns, ReadError, Reading, read_files
from studies.reaction_time.tables.numbers import number_of
from studies.reaction_time.tables.text import MOST_BYTES

MS = Columns(rt="rt_ms")
TIMES = [434, 301, 487, 413, 280, 453, 357, 553]


def table(folder: Path, content: str | bytes, name: str = "a.csv") -> Path:
    path = folder / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


def read(path: Path, columns: Columns = MS) -> Reading:
    (reading,) = read_files([path], columns)
    return reading


def rows(code: str = "D1") -> str:
    return "".join(f"{code},{time}\n" for time in TIMES)


def times_ms(reading: Reading) -> list[float]:
    return [round(row.rt_s * 1000) for row in reading.rows if row.rt_s is not None]


# --- layouts ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_lines_may_end_in_any_of_the_three_ways(tmp_path, end):
    reading = read(table(tmp_path, ("participant_id,rt_ms\n" + rows()).replace("\n", end)))
    assert times_ms(reading) == TIMES
    assert reading.rows[2].source == "a.csv:4"


@pytest.mark.parametrize("sign", ["\u2028", "\u2029", "\x85", "\x0b", "\x0c", "\x1c"])
def test_other_separators_are_part_of_a_cell(tmp_path, sign):
    text = "participant_id,note,rt_ms\n" + "".join(f"D1,go{sign}left,{time}\n" for time in TIMES)
    reading = read(table(tmp_path, text))
    assert times_ms(reading) == TIMES
    assert reading.rows[7].source == "a.csv:9"


def test_a_row_of_several_lines_is_named_by_its_first(tmp_path):
    reading = read(table(tmp_path, 'participant_id,note,rt_ms\nD1,"a\nb\nc",434\nD1,d,301\n'))
    assert [row.source for row in reading.rows] == ["a.csv:2", "a.csv:5"]


def test_a_quotation_mark_that_never_closes_is_named_with_its_line(tmp_path):
    path = table(tmp_path, 'participant_id,note,rt_ms\nD1,a,434\nD1,"b,301\nD1,c,487\nD1,d,413\n')
    with pytest.raises(ReadError, match=r"a.csv:3: a quotation mark is opened in this line and never closed"):
        read(path)


def test_excels_separator_line_is_taken_for_what_it_is(tmp_path):
    reading = read(table(tmp_path, "\ufeffsep=;\r\nparticipant_id;rt_ms\r\nD1;434\r\nD1;301\r\n"))
    assert times_ms(reading) == [434, 301]
    assert reading.rows[0].source == "a.csv:3"


def test_lines_before_the_header_are_passed_over_and_said(tmp_path):
    reading = read(
        table(
            tmp_path,
            "Exported by LabTool 3\nDate: 4.3.2026\n\nparticipant_id,trial,rt_ms\n"
            + "".join(f"D1,{i},{t}\n" for i, t in enumerate(TIMES)),
        )
    )
    assert times_ms(reading) == TIMES
    assert "before the header (line 4): 'Exported by LabTool 3'" in reading.notes[0]


def test_the_header_again_in_a_joined_file_is_counted_and_said(tmp_path):
    reading = read(
        table(tmp_path, ("participant_id,rt_ms\n" + rows()) + ("\ufeffparticipant_id,rt_ms\n" + rows("D2")))
    )
    assert times_ms(reading) == TIMES * 2
    assert reading.left_out == {"the header again": 1}
    assert "line 10" in reading.notes[0]


def test_joined_files_of_different_layout_are_refused_with_the_line(tmp_path):
    path = table(tmp_path, "participant_id,rt_ms\n" + rows() + "rt_ms,participant_id\n434,D2\n")
    with pytest.raises(
        ReadError, match=r"a.csv:10: the header comes again with its columns in another order"
    ):
        read(path)


def test_columns_without_a_name_do_no_harm(tmp_path):
    reading = read(
        table(tmp_path, ",participant_id,rt_ms,\n" + "".join(f"{i},D1,{t},\n" for i, t in enumerate(TIMES)))
    )
    assert times_ms(reading) == TIMES


def test_a_column_that_is_there_twice_is_taken_once_if_its_cells_agree(tmp_path):
    reading = read(table(tmp_path, "participant_id,rt_ms,rt_ms\nD1,434,434\nD1,301,301\n"))
    assert times_ms(reading) == [434, 301]
    assert "there 2 times" in reading.notes[0]


def test_a_last_line_cut_off_in_writing_is_left_out_and_said(tmp_path):
    reading = read(table(tmp_path, "participant_id,rt_ms\n" + rows() + "D"))
    assert times_ms(reading) == TIMES
    assert reading.left_out == {"cut off in writing": 1}
    assert "(10)" in reading.notes[0]


def test_a_last_number_that_may_be_cut_off_is_said(tmp_path):
    reading = read(table(tmp_path, "participant_id,rt_ms\n" + rows() + "D1,4"))
    assert any("ends in line 10 without an end of line" in note for note in reading.notes)
    assert not read(table(tmp_path, "participant_id,rt_ms\n" + rows() + "D1,402")).notes


# --- bytes --------------------------------------------------------------------------------------------------


def test_a_western_code_page_is_read_and_said(tmp_path):
    columns = Columns(rt="rt_ms", participant="Prüfling")
    reading = read(table(tmp_path, ("Prüfling,rt_ms\n" + rows("Jörg")).encode("cp1252")), columns)
    assert {row.participant for row in reading.rows} == {"Jörg"}
    assert "line 1" in reading.notes[0]
    assert "'Prüfling'" in reading.notes[0]


def test_another_code_page_may_be_named_and_a_wrong_one_is_an_error(tmp_path):
    path = table(tmp_path, ("osoba,rt_ms\n" + rows("Łukasz")).encode("cp1250"))
    columns = Columns(rt="rt_ms", participant="osoba", encoding="cp1250")
    assert {row.participant for row in read(path, columns).rows} == {"Łukasz"}
    with pytest.raises(ReadError, match="no encoding is called 'klingon'"):
        read(path, Columns(rt="rt_ms", encoding="klingon"))
    with pytest.raises(ReadError, match=r"a.csv:2: cannot be read as text in utf-8"):
        read(path, Columns(rt="rt_ms", encoding="utf-8"))


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-le", "utf-16-be", "utf-32", "utf-8-sig"])
def test_unicode_in_all_its_forms_is_read(tmp_path, encoding):
    assert times_ms(read(table(tmp_path, ("participant_id,rt_ms\n" + rows()).encode(encoding)))) == TIMES


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"PK\x03\x04rest", "an Excel or OpenDocument workbook"),
        (b"\xd0\xcf\x11\xe0rest", "E-Prime .edat"),
        (b"participant_id,rt_ms\nD1,4\x00\x0034\n", r"a.csv:2: a zero byte"),
    ],
)
def test_files_that_are_no_text_are_named_for_what_they_are(tmp_path, content, words):
    with pytest.raises(ReadError, match=words):
        read(table(tmp_path, content))


def test_a_cut_gzip_file_says_after_which_line_and_what_to_do(tmp_path):
    packed = gzip.compress(
        ("participant_id,rt_ms\n" + "".join(f"D1,{200 + 7919 * i % 997}\n" for i in range(5000))).encode()
    )
    with pytest.raises(ReadError, match=r"ends in the middle, after line \d+ of the table.*gzip -cd"):
        read(table(tmp_path, packed[: len(packed) // 2], "a.csv.gz"))
    damaged = packed[:40] + bytes(byte ^ 0xFF for byte in packed[40:60]) + packed[60:]
    with pytest.raises(ReadError, match="the compressed file is damaged"):
        read(table(tmp_path, damaged, "a.csv.gz"))
    with pytest.raises(ReadError, match="does not begin like one"):
        read(table(tmp_path, "rt_ms\n1\n", "a.csv.gz"))
    joined = gzip.compress(b"participant_id,rt_ms\nD1,434\n") + gzip.compress(b"D1,301\n")
    assert times_ms(read(table(tmp_path, joined, "b.csv.gz"))) == [434, 301]


def test_a_small_file_that_unpacks_to_gigabytes_is_refused_in_bounded_memory(tmp_path):
    packer = zlib.compressobj(9, wbits=31)
    packed = packer.compress(b"participant_id,rt_ms\n") + packer.flush(zlib.Z_FULL_FLUSH)
    # After a full flush a block does not depend on what came before: it is packed once, and repeated.
    packed += 2000 * (packer.compress(b"a,1\n" * 2**18) + packer.flush(zlib.Z_FULL_FLUSH))
    path = table(tmp_path, packed, "bomb.csv.gz")
    assert len(packed) < 5 * 2**20
    code = (
        "import resource, sys\nfrom pathlib import Path\nfrom studies.reaction_time.tables.text import"
        " read_text\nbefore = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss\ntry:"
        f" read_text(Path({str(path)!r}))\nexcept ValueError as error:"
        " print(error)\nprint(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)"
    )
    said = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    ).stdout.split("\n")
    assert f"more than {MOST_BYTES // 2**20} MB of text" in said[0]
    assert int(said[1]) * 1024 < 4 * MOST_BYTES


# --- numbers ------------------------------------------------------------------------------------------------

COMMA, POINT = Columns(decimal=","), Columns()


@pytest.mark.parametrize(
    ("text", "columns", "value"),
    [
        ("0,431", COMMA, 0.431),
        ("1\u00a0220,5", COMMA, 1220.5),
        ("1\u202f220,5", COMMA, 1220.5),
        ("1 220", COMMA, 1220.0),
        ("1.220,5", COMMA, 1220.5),
        ("1'234'567,25", COMMA, 1234567.25),
        ("1,220.5", POINT, 1220.5),
        ("1\u2019220.5", POINT, 1220.5),
        ("4.2E-1", POINT, 0.42),
        ("-0.3", POINT, -0.3),
        ("inf", POINT, None),
        ("<NA>", POINT, None),
        ("n/a   ", POINT, None),
    ],
)
def test_numbers_are_read_as_any_locale_writes_them(text, columns, value):
    assert number_of(text, "x", columns) == value


@pytest.mark.parametrize(
    ("text", "columns", "advice"),
    [
        ("1.023", COMMA, "a point may separate decimals or thousands"),
        ("1,220", POINT, "decimal=','"),
        ("1\u00a0220,5", POINT, "decimal=','"),
        ("0.4 s", POINT, "take the unit out of the cells"),
        ("True", POINT, "not a number"),
        ("1_000", POINT, "not a number"),
        ("[0.4, 0.8]", POINT, "--list first"),
    ],
)
def test_what_may_be_read_in_two_ways_or_not_at_all_is_refused_with_advice(text, columns, advice):
    with pytest.raises(ReadError, match=advice):
        number_of(text, "a.csv:2: column 'rt'", columns)


@given(
    st.floats(0.0, 1e6, allow_nan=False).map(lambda x: round(x, 3)),
    st.sampled_from(["\u00a0", "\u202f", "'", "."]),
)
def test_a_number_with_german_signs_is_the_same_number(value, group):
    text = f"{value:,.3f}".replace(",", "_").replace(".", ",").replace("_", group)
    assert number_of(text, "x", COMMA) == pytest.approx(value)


# --- columns and units --------------------------------------------------------------------------------------


def test_a_missing_column_is_answered_with_the_likely_ones_and_never_with_all_names(tmp_path):
    names = [f"question_{i}" for i in range(90)]
    header = ",".join(["participant_id", *names, "key_resp.rt", "reaction_time"])
    with pytest.raises(ReadError, match=r"no column 'rt_ms' among 93 columns; likely are") as caught:
        read(table(tmp_path, header + "\n" + ",".join(["D1", *["x"] * 90, "0.4", "412"]) + "\n"))
    assert "'key_resp.rt'" in str(caught.value)
    assert "'reaction_time'" in str(caught.value)
    assert "question_7" not in str(caught.value)
    with pytest.raises(ReadError, match="likely is 'RT_ms'"):
        read(table(tmp_path, "participant_id,RT_ms\nD1,4\n"))
    with pytest.raises(ReadError, match="is the header missing"):
        read(table(tmp_path, "D1,434\nD1,301\n"))


def test_a_participants_column_that_is_not_there_is_an_error_and_one_that_may_be_meant_is_said(tmp_path):
    path = table(tmp_path, "subject,rt_ms\n" + rows("S1") + rows("S2"))
    with pytest.raises(
        ReadError, match=r"no column 'subjekt'.*likely is 'subject'.*--column participant=NAME"
    ):
        read(path, Columns(rt="rt_ms", participant="subjekt"))
    reading = read(path)
    assert {row.participant for row in reading.rows} == {"a"}
    assert "Does 'subject' tell them apart?" in reading.notes[0]


def test_times_on_a_clock_are_refused_and_sorted_reactions_are_not(tmp_path):
    clock = "participant_id,rt_s\n" + "".join(f"K,{10 + 2.3 * i}\n" for i in range(12))
    with pytest.raises(
        ReadError, match=r"grows from row to row for 'K', from 10 to 35.3 s: it holds times on a clock"
    ):
        read(table(tmp_path, clock), Columns(rt="rt_s"))
    ordered = "participant_id,rt_ms\n" + "".join(f"K,{time}\n" for time in sorted(range(300, 900, 17)))
    assert len(read(table(tmp_path, ordered)).rows) == 36


def bids(folder: Path, sidecars: dict[str, str]) -> Path:
    beh = folder / "sub-01" / "beh"
    beh.mkdir(parents=True)
    (folder / "dataset_description.json").write_text("{}")
    for name, unit in sidecars.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(f'{{"response_time": {{"Units": "{unit}"}}}}')
    path = beh / "sub-01_task-go_events.tsv"
    path.write_text("onset\tresponse_time\n" + "".join(f"1\t{time}\n" for time in [*TIMES, -150]))
    return path


@pytest.mark.parametrize(
    "sidecars",
    [
        {"task-go_events.json": "ms"},
        {"events.json": "ms"},
        {"sub-01/sub-01_events.json": "ms"},
        {"task-go_events.json": "us", "sub-01/beh/sub-01_task-go_events.json": "ms"},  # the nearest wins
        {"events.json": "us", "task-go_events.json": "ms"},  # the more particular wins
        {
            "task-stop_events.json": "us",
            "task-go_beh.json": "us",
            "task-go_events.json": "ms",
        },  # others' do not apply
    ],
)
def test_the_unit_is_inherited_from_the_sidecar_that_applies(tmp_path, sidecars):
    reading = read(bids(tmp_path / "ds", sidecars), Columns())
    assert times_ms(reading) == [*TIMES, -150]
    assert reading.rows[-1].status == "anticipation"


def test_a_sidecar_above_the_data_set_is_not_its_own(tmp_path):
    (tmp_path / "events.json").write_text('{"response_time": {"Units": "us"}}')
    path = bids(tmp_path / "ds", {"events.json": "ms"})
    assert times_ms(read(path, Columns())) == [*TIMES, -150]
    (tmp_path / "ds" / "events.json").unlink()
    with pytest.raises(ReadError, match="read in s has a median"):
        read(path, Columns())


def test_times_equal_to_the_stated_time_out_are_time_outs(tmp_path):
    path = table(tmp_path, "participant_id,rt_ms\n" + rows() + "D1,2000\nD1,2000\nD1,2100\n")
    reading = read(path, Columns(rt="rt_ms", waited_s=2.0))
    assert [row.status for row in reading.rows[-3:]] == ["time-out", "time-out", "ok"]
    assert reading.taken == {"rows": 9, "at the time-out": 2}


def test_what_a_file_says_of_itself_reaches_nobodys_terminal_as_a_command(tmp_path):
    path = table(tmp_path, "participant_id,rt_ms\n" + rows("D\x1b]0;owned\x07\u202e"))
    assert {row.participant for row in read(path).rows} == {r"D\x1b]0;owned\x07\u202e"}
    for bad in ("\x1b[2J", "x\x1b[31m"):
        with pytest.raises(ReadError) as caught:
            read(table(tmp_path, f"participant_id,rt_ms\nD1,{bad}\n"))
        assert "\x1b" not in str(caught.value)
