"""Reading a study: everything it names is there, and every mistake is said at once."""

import os
import sys
from pathlib import Path

import pytest

from arl_tui.commands.study_page import page
from core.configuration.catalogue import settings_of, tables_of
from core.session.protocol_reading import protocol_from
from studies.lab.config import Study
from studies.lab.questions import QuestionList
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
        ("participants = 8", "participant = 8", r"toml:4: participant = 8: .* did you mean `participants`\?"),
        ("participants = 8", "", "the key `participants` is missing"),
        (
            "participants = 8",
            "participants = 0",
            r"toml:4: participants = 0: expected a whole number 1 to 100000",
        ),
        (
            'type = "latin-square"',
            'type = "latin"',
            r'toml:16: \[assignment\] type = "latin": expected one of',
        ),
        ('type = "block"', 'type = "blok"', r'toml:24: .*did you mean "block"\?'),
        ('type = "block"', 'type = "block"\ngame = 2', r"toml:25: .*did you mean `games`\?"),
        ("episodes = 3", "episodez = 3", r"toml:7: \[protocol.session\] episodez = 3: .*`episodes`\?$"),
        ('name = "small"', 'name = "s t"', r"toml:2: name = .* letters, digits"),
        ("seed = 1", "seed = ", r"toml:3: not a TOML file"),
        ('questions = "sus"', 'questions = "suss"', "there is no such file"),
        ('text = "consent.md"', 'text = "other.md"', "other.md: needed by step 1 of sitting 1"),
        ('text = "consent.md"', 'text = ""', r'text = "": expected a text: not empty'),
        ('[[sittings.steps]]\ntype = "block"\n', "", "1 blocks with an assigned condition"),
        (
            'type = "annealed"',
            'type = "anealed"',
            r"toml:13: \[conditions.annealed.agent.scheme\] .*`?annealed",
        ),
        ('type = "consent"\ntext = "consent.md"', 'type = "break"', "before consent was given"),
    ],
)
def test_mistakes_are_named(write, old, new, message):
    with pytest.raises(StudyError, match=message):
        load_study(write(STUDY.replace(old, new, 1)))


@pytest.mark.skipif(sys.platform == "win32", reason="no such pipes and devices")
@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            getattr(os, "mkfifo", None),
            "consent.md: needed by step 1 of sitting 1: a pipe or a device, not a file",
        ),
        (lambda path: path.symlink_to("/dev/zero"), "a pipe or a device, not a file"),
        (lambda path: path.write_text("a" * 1_000_001), "a page has at most 1000000 characters"),
        (lambda path: path.write_bytes(b"a\n\xfc"), r"0xfc is none of UTF-8: save the page as UTF-8"),
        (Path.mkdir, "needed by step 1 of sitting 1: Is a directory"),
    ],
    ids=["pipe", "device", "long", "Latin-1", "folder"],
)
def test_a_page_that_is_no_text_is_named_and_not_waited_for(write, make, message):
    path = write()
    (path.parent / "consent.md").unlink()
    make(path.parent / "consent.md")
    with pytest.raises(StudyError, match=message):
        load_study(path)


def test_a_file_with_a_byte_order_mark_is_read(write):
    path = write()
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes())
    assert load_study(path).study.name == "small"


def test_a_file_that_is_not_utf8_is_told_how_to_become_it(write):
    path = write()
    path.write_bytes(path.read_bytes() + "# für\n".encode("latin-1"))
    with pytest.raises(StudyError, match="Save it as UTF-8"):
        load_study(path)


def test_a_mistake_in_a_list_over_several_lines_is_found_in_its_line(write):
    steps = STUDY[STUDY.index("[[sittings.steps]]") :]
    listed = """steps = [
  { type = "consent", text = "consent.md", statements = [
    "I agree, [really] = {yes}.", # a comment } ]
  ] },
  { type = "block" }, { type = "block", games = 0 },
]
"""
    text = STUDY.replace(steps, listed)
    line = text[: text.index("games = 0")].count("\n") + 1
    with pytest.raises(StudyError, match=rf"toml:{line}: \[sittings.1.steps.3\] games = 0: expected a whole"):
        load_study(write(text))


def test_a_fault_of_the_base_is_said_once_and_one_of_a_condition_where_it_stands(write):
    with pytest.raises(StudyError) as caught:
        load_study(write(STUDY.replace("episodes = 3", "episodes = 0")))
    assert str(caught.value).count("episodes = 0") == 1


def test_the_page_of_settings_is_the_one_that_the_program_prints():
    written = (Path(__file__).parents[3] / "docs" / "study.md").read_text(encoding="utf-8")
    assert written == page(), "write it again: arl study settings > docs/study.md"


def test_every_key_of_every_table_has_a_meaning():
    undocumented = [
        f"{struct.__name__}.{setting.key}"
        for root in (Study, QuestionList)
        for struct in [
            root,
            *(inner for _, kind in tables_of(root) for inner in (kind.structs or {}).values()),
        ]
        for setting in settings_of(struct).values()
        if not setting.doc and setting.kind.structs is None
    ]
    assert undocumented == []
