"""BIDS data sets: the validator finds no error, and no warning that could be avoided."""

import csv
import json
import shutil
import subprocess
import sysconfig
from pathlib import Path

import msgspec
import pytest

from core.recording.recorder import LineWriter
from studies.exports.bids import BidsSettings, export_bids
from studies.exports.tidy import ExportError
from tests.core.recording.test_recording import HEADER, press
from tests.studies.exports.conftest import REFERENCE, run

SETTINGS = BidsSettings(
    name="Reference recordings",
    authors=("A. Author", "B. Author"),
    licence="CC0",
    institution="Institute",
    institution_address="Street 1",
    department="Department",
)
UNAVOIDABLE = {"CogAtlasID", "CogPOID"}
"""Terms of task catalogues: there is none for judging an agent's play."""


def validator() -> str:
    beside = Path(sysconfig.get_path("scripts")) / "bids-validator-deno"
    found = str(beside) if beside.exists() else shutil.which("bids-validator-deno")
    if found is None:
        pytest.skip("bids-validator-deno is not installed: pip install 'arl-tui[dev]'")
    return found


def issues(folder: Path) -> list[dict[str, str]]:
    done = subprocess.run(
        [validator(), "--json", folder], capture_output=True, text=True, check=False, timeout=120
    )
    return json.loads(done.stdout)["issues"]["issues"]


def table(path: Path) -> list[dict[str, str]]:
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file, delimiter="\t"))


def check(folder: Path) -> None:
    found = issues(folder)
    assert [issue for issue in found if issue["severity"] == "error"] == []
    avoidable = [issue for issue in found if issue.get("subCode") not in UNAVOIDABLE]
    assert avoidable == []
    assert found, "the validator has looked at the files"


def test_the_validator_accepts_all_reference_recordings(tmp_path):
    export_bids(REFERENCE, tmp_path / "bids", SETTINGS)
    check(tmp_path / "bids")


def test_the_validator_accepts_a_study_and_reaction_trials(lab, tmp_path):
    exported = export_bids(lab, tmp_path / "bids", SETTINGS)
    assert any(path.name.endswith("_beh.tsv") for path in exported.files)
    check(tmp_path / "bids")


def test_the_validator_would_find_a_fault(tmp_path):
    exported = export_bids(REFERENCE, tmp_path / "bids", SETTINGS)
    path = tmp_path / "bids" / next(path for path in exported.files if path.name.endswith("_events.tsv"))
    path.write_text(path.read_text().replace("onset", "beginning", 1))
    assert any(issue["severity"] == "error" for issue in issues(tmp_path / "bids"))


def test_events_are_sorted_and_hold_every_press_and_step(lab, tmp_path):
    exported = export_bids(lab / "tetris-linear-equation-4.jsonl", tmp_path / "bids")
    rows = table(tmp_path / "bids" / exported.files[0])
    onsets = [float(row["onset"]) for row in rows]
    assert onsets == sorted(onsets)
    kinds = [row["trial_type"] for row in rows]
    assert (kinds.count("game"), kinds.count("step"), kinds.count("press")) == (3, 36, 24)


def test_every_column_is_described_with_its_unit(tmp_path):
    exported = export_bids(REFERENCE, tmp_path / "bids")
    rows = table(tmp_path / "bids" / exported.files[0])
    sidecar = json.loads((tmp_path / "bids" / "task-tetris_events.json").read_text())
    assert set(rows[0]) <= set(sidecar)
    assert sidecar["onset"]["Units"] == sidecar["response_time"]["Units"] == "s"
    assert sidecar["verdict"]["Levels"]["repeat"]


def test_dates_and_typed_texts_are_left_out_unless_asked_for(lab, tmp_path):
    export_bids(lab, tmp_path / "without")
    export_bids(lab, tmp_path / "with", BidsSettings(dates=True, free_text=True))

    def everything(folder):
        return "".join(path.read_text(encoding="utf-8") for path in folder.rglob("*") if path.is_file())

    assert "2026-" not in everything(tmp_path / "without")
    assert "comment" not in everything(tmp_path / "without")
    assert "2026-" in everything(tmp_path / "with")
    assert list((tmp_path / "with").rglob("*_scans.tsv"))


def test_participants_whose_labels_would_be_the_same_are_refused(tmp_path):
    for code in ("P-01", "P_01"):
        writer = LineWriter(
            tmp_path / "data" / f"{code}.jsonl", msgspec.structs.replace(HEADER, participant=code)
        )
        writer.write(press(0))
        writer.close()
    with pytest.raises(ExportError, match="both be sub-P01"):
        export_bids(tmp_path / "data", tmp_path / "bids")


def test_what_was_not_said_about_the_data_set_is_named(tmp_path):
    output = run("export", "bids", REFERENCE, "--out", tmp_path / "bids", "--licence", "CC0")
    assert "the validator will warn of it: --author (two or more), --institution" in output
    assert "--licence" not in output
