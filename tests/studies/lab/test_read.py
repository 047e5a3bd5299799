"""Reading a study: everything it names is there, and every mistake is said at once."""

import pytest

from core.session.protocol import protocol_from
from studies.lab.read import StudyError, combined, load_study

STUDY = """
name = "small"
seed = 1
participants = 8

[protocol.session]
episodes = 3

[conditions.linear.agent.scheme]
type = "linear"

[conditions.annealed.agent.scheme]
type = "annealed"

[assignment]
type = "latin-square"

[[sittings]]
name = "day 1"
[[sittings.steps]]
type = "consent"
text = "consent.md"
[[sittings.steps]]
type = "block"
[[sittings.steps]]
type = "block"
[[sittings.steps]]
type = "questionnaire"
questions = "sus"
"""


@pytest.fixture
def write(tmp_path):
    def write_study(text=STUDY, **files):
        (tmp_path / "consent.md").write_text("# Consent\n")
        path = tmp_path / "study.toml"
        path.write_text(text)
        return path

    return write_study


def test_a_condition_is_the_base_protocol_with_its_differences(write):
    loaded = load_study(write())
    assert {name: p.session.episodes for name, p in loaded.protocols.items()} == {"linear": 3, "annealed": 3}
    assert type(loaded.protocols["annealed"].agent.scheme).__name__ == "Annealed"
    assert loaded.texts == {"consent.md": "# Consent\n"}
    assert list(loaded.questionnaires) == ["sus"]


def test_a_table_of_another_type_replaces_the_whole_table():
    base = {"agent": {"scheme": {"type": "annealed", "beta_0": 0.5}, "w_r": 1.0}}
    assert combined(base, {"agent": {"scheme": {"type": "linear"}}}) == {
        "agent": {"scheme": {"type": "linear"}, "w_r": 1.0}
    }
    assert combined(base, {"agent": {"scheme": {"beta_0": 0.1}}})["agent"]["scheme"] == {
        "type": "annealed",
        "beta_0": 0.1,
    }


def test_the_base_alone_is_the_protocol_it_describes():
    base = {"session": {"episodes": 4}}
    assert protocol_from(combined(base, {})) == protocol_from(base)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("participants = 8", "participant = 8", "participant"),
        ('type = "latin-square"', 'type = "latin"', "latin"),
        ('questions = "sus"', 'questions = "suss"', "there is no such file"),
        ('text = "consent.md"', 'text = "other.md"', "other.md: needed by step 1 of sitting 1"),
        ('[[sittings.steps]]\ntype = "block"\n', "", "1 blocks with an assigned condition"),
        ('type = "annealed"', 'type = "anealed"', "condition annealed"),
        ('type = "consent"\ntext = "consent.md"', 'type = "break"', "before consent was given"),
    ],
)
def test_mistakes_are_named(write, old, new, message):
    with pytest.raises(StudyError, match=message):
        load_study(write(STUDY.replace(old, new, 1)))


def test_a_file_with_a_byte_order_mark_is_read(write):
    path = write()
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes())
    assert load_study(path).study.name == "small"


def test_a_file_that_is_not_utf8_is_told_how_to_become_it(write):
    path = write()
    path.write_bytes(path.read_bytes() + "# für\n".encode("latin-1"))
    with pytest.raises(StudyError, match="save the file as UTF-8"):
        load_study(path)
