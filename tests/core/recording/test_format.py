"""The format as others see it: JSON Schema, readers in other languages, upgraded files."""

import importlib.util
import json
import shutil
import subprocess
from pathlib import Path

import pytest

from core.events import CreditGiven, Input, KeyPressed, Output, PressRetracted, StopAsked
from core.recording.json_schema import records_of, schema_of
from core.recording.reader import RecordingError, read_recording
from core.recording.schema import VERSION
from core.recording.summary import summarise_recording
from core.recording.upgrade import upgraded
from core.session.protocol_reading import protocol_from
from core.session.replay import replay_exactly
from core.session.session import build_session

REPOSITORY = Path(__file__).resolve().parents[3]
REFERENCE = REPOSITORY / "recordings" / "reference"
FILES = sorted(REFERENCE.rglob("*.jsonl"))
OLD = sorted(REFERENCE.glob("*.jsonl"))
EXAMPLES = REPOSITORY / "docs" / "examples"


@pytest.mark.parametrize("version", range(1, VERSION + 1))
def test_the_committed_schema_is_the_present_one(version):
    path = REPOSITORY / "recordings" / "schema" / f"version-{version}.json"
    assert json.loads(path.read_text(encoding="utf-8")) == schema_of(version), (
        f"arl recordings schema --version {version} > {path.relative_to(REPOSITORY)}"
    )


@pytest.mark.parametrize("path", FILES, ids=lambda path: f"{path.parent.name}-{path.stem}")
def test_every_line_of_the_reference_recordings_is_valid(path):
    jsonschema = pytest.importorskip("jsonschema", reason="jsonschema is not installed")
    lines = [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]
    schema = schema_of(lines[0]["version"])
    jsonschema.Draft202012Validator.check_schema(schema)
    validator = jsonschema.Draft202012Validator(schema)
    for line in lines:
        validator.validate(line)
    other = jsonschema.Draft202012Validator(schema_of(3 - lines[0]["version"]))
    assert not other.is_valid(lines[0])
    assert not validator.is_valid({**lines[1], "more": 1})
    assert not validator.is_valid({name: value for name, value in lines[1].items() if name != "chain"})


def test_the_schema_knows_every_event():
    tags = {str(kind.__struct_config__.tag) for kind in (*Input.__args__, *Output.__args__)}
    assert set(schema_of()["$defs"]) == tags | {"header", "end"}
    assert len(records_of(VERSION)) == len(tags) + 2


def python_reader():
    spec = importlib.util.spec_from_file_location("read_recording_example", EXAMPLES / "read_recording.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("path", FILES, ids=lambda path: f"{path.parent.name}-{path.stem}")
def test_the_reader_in_plain_python_reads_what_ours_reads(path):
    header, events, closed = python_reader().read(str(path))
    ours = read_recording(path)
    assert (header["participant"], header["root_seed"], closed) == (
        ours.header.participant,
        ours.header.root_seed,
        ours.complete,
    )
    assert [event["type"] for event in events] == [str(e.__struct_config__.tag) for e in ours.events]
    taken_back = {event.press for event in ours.events if isinstance(event, PressRetracted)}
    credit = {event.press: event for event in ours.events if isinstance(event, CreditGiven)}
    expected = [
        (
            event.press,
            event.value,
            event.step,
            dict(zip(credit[event.press].steps, credit[event.press].shares, strict=True)),
        )
        for event in ours.events
        if isinstance(event, KeyPressed) and event.verdict == "accepted" and event.press not in taken_back
    ]
    found = python_reader().presses(header, events)
    assert [(press["press"], press["value"], press["step"], press["credit"]) for press in found] == expected


@pytest.mark.parametrize("line", [1, 2, 40, 130])
def test_the_reader_in_plain_python_names_a_changed_line(line, tmp_path):
    lines = (REFERENCE / "tetris-linear-equation-4.jsonl").read_bytes().split(b"\n")
    lines[line - 1] = lines[line - 1].replace(b'"type"', b'"kind"', 1)
    path = tmp_path / "changed.jsonl"
    path.write_bytes(b"\n".join(lines))
    with pytest.raises(ValueError, match=f":{line}: "):
        python_reader().read(str(path))
    with pytest.raises(RecordingError, match=f":{line}: "):
        read_recording(path)


def test_a_session_that_was_cut_off_is_read_by_both(tmp_path):
    path = tmp_path / "cut.jsonl"
    path.write_bytes((REFERENCE / "tetris-linear-equation-4.jsonl").read_bytes()[:-2000])
    _, events, closed = python_reader().read(str(path))
    ours = read_recording(path)
    assert (len(events), closed) == (len(ours.events), ours.complete) == (len(ours.events), False)


def test_the_reader_in_r_reads_what_ours_reads():
    if shutil.which("Rscript") is None:
        pytest.skip("Rscript is not on this machine")
    path = REFERENCE / "tetris-linear-equation-4.jsonl"
    done = subprocess.run(
        ["Rscript", EXAMPLES / "read_recording.R", path], capture_output=True, text=True, check=False
    )
    if "there is no package called" in done.stderr:
        pytest.skip(f"R lacks a package: {done.stderr.strip()}")
    assert done.returncode == 0, done.stderr
    header, events, _ = python_reader().read(str(path))
    rows = [line.split(",") for line in done.stdout.splitlines()[1:]]
    expected = python_reader().presses(header, events)
    assert [[float(cell) for cell in row] for row in rows] == [
        pytest.approx([press["press"], press["time_s"], press["value"], press["step"]]) for press in expected
    ]


@pytest.mark.parametrize("name", ["read_recording.py", "read_recording.R"])
def test_a_reader_has_at_most_sixty_lines(name):
    assert len((EXAMPLES / name).read_text(encoding="utf-8").splitlines()) <= 60


@pytest.mark.parametrize("path", OLD, ids=lambda path: path.stem)
@pytest.mark.jit
def test_an_upgraded_file_replays_exactly(path, tmp_path):
    before = path.read_bytes()
    new = tmp_path / "new.jsonl"
    new.write_bytes(upgraded(read_recording(path)))
    recording = read_recording(new, allow_truncated=False)
    assert recording.header.version == VERSION
    assert recording.header.source["upgraded_from_version"] == "1"
    assert recording.events == read_recording(path).events
    session = build_session(protocol_from(recording.header.protocol), recording.header.root_seed)
    assert replay_exactly(recording, session).difference is None
    assert path.read_bytes() == before


def test_an_upgraded_file_claims_no_more_than_its_old_version_knew(tmp_path):
    path = tmp_path / "old.jsonl"
    recording = read_recording(OLD[0])
    stopped = StopAsked(time_ns=10**12, reason="participant")
    path.write_bytes(OLD[0].read_bytes())
    old = type(recording)(path, recording.header, (*recording.events, stopped), True)
    new = tmp_path / "new.jsonl"
    new.write_bytes(upgraded(old))
    assert summarise_recording(read_recording(new)).ending.words == summarise_recording(old).ending.words
    assert "version 1 does not tell" in summarise_recording(old).ending.words


def test_a_present_file_is_not_upgraded():
    with pytest.raises(ValueError, match="already"):
        upgraded(read_recording(REFERENCE / "version-2" / OLD[0].name))


def test_the_command_upgrades_a_folder_and_touches_nothing(tmp_path):
    from click.testing import CliRunner

    from arl_tui.cli import main

    folder = tmp_path / "data"
    shutil.copytree(REFERENCE, folder)
    before = {path: path.read_bytes() for path in folder.rglob("*.jsonl")}
    result = CliRunner().invoke(main, ["recordings", "upgrade", str(folder), str(tmp_path / "new")])
    assert result.exit_code == 0, result.output
    assert f"{len(OLD)} of version 2 already" in result.output
    assert {path.name for path in (tmp_path / "new").rglob("*.jsonl")} == {path.name for path in OLD}
    assert {path: path.read_bytes() for path in folder.rglob("*.jsonl")} == before
    assert read_recording(tmp_path / "new" / OLD[0].name).header.version == VERSION
