"""Anonymised copies of a whole lab's folder: nothing of the old codes, dates and typed answers is left."""

import json
import re
from pathlib import Path

import pytest
from click.testing import CliRunner

from arl_tui.cli import main
from core.recording.anonymise import NO_TEXT, Anonymising
from core.recording.reader import read_recording
from studies.exports.anonymise import AnonymiseError, read_or_make_key
from studies.exports.archive import ArchiveSettings, make_archive
from studies.lab.sitting_log import FileRecorded, QuestionAnswered, read_sitting
from studies.reaction_time.trial_log import read_trials
from tests.studies.exports.conftest import run


@pytest.fixture(scope="module")
def copies(lab, study_file, tmp_path_factory):
    place = tmp_path_factory.mktemp("anonymised")
    run("anonymise", lab, place / "copies", "--key", place / "elsewhere" / "key", "--study", study_file)
    return place / "copies"


def codes(lab: Path) -> set[str]:
    return {path.name for path in lab.glob("studies/*/participants/*")} | {"P01"}


def test_no_code_and_no_date_is_left_in_names_and_files(lab, copies):
    for path in copies.rglob("*"):
        text = str(path.relative_to(copies)) + (path.read_text(encoding="utf-8") if path.is_file() else "")
        for code in codes(lab):
            assert code not in text, path
        assert not re.search(r"20\d\d-[01]\d-[0-3]\d|20\d{6}T", text), path


def test_every_recording_has_a_copy_with_the_same_events(lab, copies):
    def events(folder):
        found = [
            read_recording(path)
            for path in folder.rglob("*.jsonl")
            if b'"arl-recording"' in path.read_bytes()
        ]
        return sorted(str(recording.events) for recording in found)

    assert events(copies) == events(lab)


def test_a_sitting_names_the_copies_of_its_recordings_and_keeps_all_but_typed_answers(copies):
    for path in copies.rglob("sitting-1.jsonl"):
        header, lines = read_sitting(path)
        assert header.participant == path.parent.name
        for line in lines:
            if isinstance(line, FileRecorded):
                assert read_recording(path.parent / line.file).header.participant == header.participant
            if isinstance(line, QuestionAnswered) and line.question == "remark":
                assert line.answer == NO_TEXT
            if isinstance(line, QuestionAnswered) and line.question == "hand":
                assert line.answer in ("left", "right")


def test_reaction_trials_keep_their_times(lab, copies):
    old, new = (read_trials(next((folder / "calibration").iterdir())) for folder in (lab, copies))
    assert old.trials == new.trials
    assert "anonymised_from_sha256" in new.header.facts


def test_the_ledger_is_left_out_and_named(lab, study_file, tmp_path):
    result = CliRunner().invoke(
        main, ["anonymise", str(lab), str(tmp_path / "copies"), "--key", str(tmp_path / "key")]
    )
    assert "Left out" in result.output
    assert "ledger.jsonl" in result.output


def test_a_folder_without_data_is_said_to_hold_nothing(tmp_path):
    (tmp_path / "empty").mkdir()
    result = CliRunner().invoke(
        main, ["anonymise", str(tmp_path / "empty"), str(tmp_path / "copies"), "--key", str(tmp_path / "key")]
    )
    assert result.exit_code == 1
    assert "there is nothing to copy: no recordings, reaction trials or sittings" in result.output


def test_the_same_key_gives_the_same_codes_and_is_never_among_the_data(lab, tmp_path):
    key = read_or_make_key(tmp_path / "key", apart_from=(lab,))
    assert key == read_or_make_key(tmp_path / "key", apart_from=(lab,))
    with pytest.raises(AnonymiseError, match="beside the data"):
        read_or_make_key(lab / "key", apart_from=(lab,))
    assert not (lab / "key").exists()
    (tmp_path / "no-key").write_text("secret")
    with pytest.raises(AnonymiseError, match="64 hex digits"):
        read_or_make_key(tmp_path / "no-key", apart_from=(lab,))


@pytest.mark.parametrize("there", [True, False])
def test_of_an_archive_that_is_interrupted_nothing_is_left(
    there: bool, lab: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(data: Path, *_: object) -> None:
        assert list(data.rglob("*.jsonl"))
        raise KeyboardInterrupt

    monkeypatch.setattr("studies.exports.archive._exports", interrupted)
    into = tmp_path / "archive"
    if there:
        into.mkdir()
    with pytest.raises(KeyboardInterrupt):
        make_archive(lab, into, Anonymising(b"k" * 32), ArchiveSettings())
    assert list(tmp_path.rglob("*")) == ([into] if there else [])


@pytest.mark.jit
def test_an_archive_holds_everything_and_its_checksums_hold(lab, study_file, tmp_path):
    import hashlib

    archive = tmp_path / "archive"
    run(
        "archive",
        lab,
        "--out",
        archive,
        "--key",
        tmp_path / "key",
        "--study",
        study_file,
        "--author",
        "A. Author",
    )
    assert {"README.md", "data", "tables", "bids", "format", "protocols", "study", "software"} <= {
        path.name for path in archive.iterdir()
    }
    listed = dict(
        reversed(line.split("  ", 1)) for line in (archive / "checksums.sha256").read_text().splitlines()
    )
    files = {path.relative_to(archive).as_posix() for path in archive.rglob("*") if path.is_file()}
    assert set(listed) == files - {"checksums.sha256"}
    for name, digest in listed.items():
        assert hashlib.sha256((archive / name).read_bytes()).hexdigest() == digest
    for path in archive.rglob("*"):
        text = path.read_bytes() if path.is_file() and path.suffix != ".arrow" else b""
        assert not any(code.encode() in text for code in codes(lab) - {"P01"}), path
    assert {path.name for path in (archive / "study").iterdir()} == {"study.toml", "consent.md", "own.toml"}
    assert "arl-tui" in json.loads((archive / "software" / "versions.json").read_text())
