"""Tables of a session of several people: each press has the code of the participant who pressed."""

import json
from pathlib import Path

import pytest

from core.feedback.people import PersonConfig
from core.recording.anonymise import Anonymising, anonymised, removals
from core.recording.reader import Recording, read_recording
from core.session.protocol_reading import protocol_from
from core.session.replay import replay_exactly
from core.session.session import build_session
from studies.exports.event_rows import credit_rows, press_rows
from studies.exports.session_rows import SessionRows
from tests.core.sessions import simulated, small_protocol

PEOPLE = (
    PersonConfig(name="A01", good="j", bad="f", retract="u"),
    PersonConfig(name="B02", graded=("x", "c", "v", "b", "n"), retract="m"),
)


@pytest.fixture(scope="module")
def crowd(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    return simulated(tmp_path_factory.mktemp("crowd"), small_protocol(people=PEOPLE))


def test_presses_and_their_credit_have_the_code_of_who_pressed(crowd: Recording) -> None:
    session = SessionRows(crowd, crowd.path.stem)
    rows = list(press_rows(session))
    assert {(row["participant"], row["person"]) for row in rows} == {("A01", 1), ("B02", 2)}
    assert all(row["key"] in ("j", "f") for row in rows if row["participant"] == "A01")
    assert {row["judgement"] for row in rows if row["value"] == 0} <= {"neither"}
    assert {row["participant"] for row in credit_rows(session)} == {"A01", "B02"}


def test_an_anonymised_copy_has_new_codes_for_all_and_replays(crowd: Recording, tmp_path: Path) -> None:
    path = tmp_path / "copy.jsonl"
    path.write_bytes(anonymised(crowd, Anonymising(b"a secret of 16 bytes", removals(()))))
    content = path.read_text()
    for person in PEOPLE:
        assert person.name not in content
    copy = read_recording(path)
    names = [person["name"] for person in copy.header.protocol["people"]]
    assert copy.header.participants == names
    assert len(set(names)) == 2
    session = build_session(protocol_from(copy.header.protocol), copy.header.root_seed)
    assert replay_exactly(copy, session).difference is None
    assert json.loads(content.splitlines()[0])["participants"] == names
