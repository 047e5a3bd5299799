"""Several people at one keyboard: whose key is which, and what each may press."""

from itertools import count

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.configuration.reading import ConfigurationError
from core.events import KeyPressed, PressRetracted
from core.feedback.delays import GammaDelay
from core.feedback.keys import KeyConfig, PressGate
from core.feedback.layouts import KeyReader
from core.feedback.people import NOBODY, PeopleGate, PersonConfig, keys_of_person, new_gate
from core.recording.schema import to_plain
from core.session.protocol import DEFAULTS, Protocol
from core.session.protocol_reading import protocol_from

MS = 1_000_000
ADA = PersonConfig(name="A01", good="j", bad="f", retract="u")
BO = PersonConfig(
    name="B02", good="w", bad="q", retract="e", max_presses_per_episode=1, delay=GammaDelay(3.0)
)
CY = PersonConfig(name="C03", graded=("x", "c", "v", "b", "n"), retract="m")


def gate(*people: PersonConfig) -> PeopleGate:
    found = PeopleGate([keys_of_person(person, KeyConfig(max_presses_per_episode=3)) for person in people])
    found.episode_started()
    return found


def pressed(who: PeopleGate, keys: str, every_ms: int = 1000) -> list[KeyPressed | PressRetracted]:
    return [record for n, key in enumerate(keys) for record in who.judge(key, n * every_ms * MS)]


def test_each_key_is_its_owners_and_says_what_it_says_for_them():
    records = pressed(gate(ADA, BO, CY), "jqvxnz")
    assert [(record.person, record.value) for record in records if isinstance(record, KeyPressed)] == [
        (0, 1.0),
        (1, -1.0),
        (2, 0.0),
        (2, -2.0),
        (2, 2.0),
        (NOBODY, None),
    ]
    assert [record.press for record in records] == list(range(6))


def test_everybody_has_presses_of_their_own():
    who = gate(ADA, BO)
    records = pressed(who, "wwjw")
    assert [record.verdict for record in records if isinstance(record, KeyPressed)] == [
        "accepted",
        "no-presses-left",
        "accepted",
        "no-presses-left",
    ]
    assert (who.left_of(0), who.left_of(1), who.left_of(NOBODY), who.presses_left) == (2, 0, 0, 2)
    who.episode_started()
    assert (who.left_of(0), who.left_of(1)) == (3, 1)


def test_a_press_is_taken_back_by_its_own_person_only():
    records = pressed(gate(ADA, BO), "jweu")
    assert [record.press for record in records if isinstance(record, PressRetracted)] == [1, 0]


def test_two_who_press_at_once_do_not_count_as_a_held_key():
    """Both keys every 40 ms apart: of one keyboard, but of two people."""
    who = gate(ADA, CY)
    records = [
        *who.judge("j", 0),
        *who.judge("n", 20 * MS),
        *who.judge("j", 1000 * MS),
        *who.judge("n", 1001 * MS),
    ]
    assert [record.verdict for record in records if isinstance(record, KeyPressed)] == ["accepted"] * 4


def test_what_is_on_screen_holds_for_everybody():
    who = gate(ADA, BO)
    who.frame, who.step, who.covered = 7, 3, True
    records = pressed(who, "jw")
    assert {(record.frame, record.step, record.verdict) for record in records} == {(7, 3, "covered")}
    assert (who.frame, who.step, who.covered, who.playing) == (7, 3, True, True)


def test_keys_of_other_layouts_are_read_for_everybody():
    who = gate(ADA, BO)
    who.reader = KeyReader()
    records = pressed(who, "оц")  # where j and w stand on a Russian keyboard
    assert [(record.person, record.value, record.read_as, record.layout) for record in records] == [
        (0, 1.0, "j", "Russian"),
        (1, 1.0, "w", "Russian"),
    ]


def test_one_person_has_the_gate_that_there_has_always_been():
    assert isinstance(new_gate([KeyConfig()], numbers=count()), PressGate)
    assert isinstance(new_gate([KeyConfig(), KeyConfig(good="w", bad="q", retract="e")]), PeopleGate)


LETTERS = "abcdefghijklmnopqrstuvwxyz"


@given(st.permutations(LETTERS), st.text(LETTERS, max_size=60), st.integers(2, 8), st.integers(1, 400))
def test_of_any_people_each_press_is_as_if_its_owner_were_alone(order, keys, n, every_ms):
    """The slow twin: each person's keys through a gate of their own."""
    people = [
        KeyConfig(
            good=order[3 * k], bad=order[3 * k + 1], retract=order[3 * k + 2], max_presses_per_episode=2
        )
        for k in range(n)
    ]
    together = PeopleGate(people)
    together.episode_started()
    records = [record for at, key in enumerate(keys) for record in together.judge(key, at * every_ms * MS)]
    for person, own in enumerate(people):
        alone = PressGate(own, person=person)
        alone.episode_started()
        expected = [
            record
            for at, key in enumerate(keys)
            if key in own.letters
            for record in alone.judge(key, at * every_ms * MS)
        ]
        mine = {
            record.press for record in records if isinstance(record, KeyPressed) and record.person == person
        }
        found = [record for record in records if record.press in mine]
        assert [type(record) for record in found] == [type(record) for record in expected]
        assert [getattr(record, "verdict", "") for record in found] == [
            getattr(record, "verdict", "") for record in expected
        ]


# --- protocols ----------------------------------------------------------------------------------------------


def protocol(*people: PersonConfig, **changes: object) -> Protocol:
    plain = {"people": [msgspec.to_builtins(person) for person in people], **changes}
    return protocol_from(plain, to_run=True)


def test_a_protocol_of_people_has_a_human_model_a_budget_and_a_delay_for_each():
    found = protocol(ADA, BO)
    assert found.n_participants == 2
    assert [keys.letters for keys in found.keys_of_people] == [("j", "f", "u"), ("w", "q", "e")]
    assert [keys.max_presses_per_episode for keys in found.keys_of_people] == [5, 1]
    assert [credit.delay for credit in found.credit_of_participants] == [
        found.agent.credit.delay,
        GammaDelay(3.0),
    ]
    assert found.participants == ["A01", "B02"]
    assert protocol_from(to_plain(found)) == found


@pytest.mark.parametrize(
    ("people", "said"),
    [
        ((ADA, msgspec.structs.replace(BO, good="j")), "A01 and B02, have the letter 'j'"),
        ((ADA, msgspec.structs.replace(BO, retract="u")), "A01 and B02, have the letter 'u'"),
        ((ADA, msgspec.structs.replace(BO, name="A01")), "two people are called A01"),
        ((ADA, msgspec.structs.replace(BO, bad="w")), "B02: good, bad and retract need three different keys"),
        ((msgspec.structs.replace(CY, graded=("x", "c")),), "C03: graded takes five keys"),
        ((msgspec.structs.replace(CY, retract="1"),), "C03: a feedback key is one lower-case letter"),
    ],
)
def test_people_who_cannot_be_told_apart_are_refused_by_their_names(people, said):
    with pytest.raises(ConfigurationError, match=said):
        protocol(*people)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"keys": {"good": "k"}}, "good"),
        ({"keys": {"retract": "z"}}, "retract"),
        ({"keys": {"graded": ["d", "f", "g", "h", "j"]}}, "graded"),
        ({"keys": {"wrong_press_rate": 0.1}}, "wrong_press_rate asks one participant"),
        ({"others": [{}, {}]}, "at most 1, got 2"),
        ({"agent": {"asking": {"per_episode": 2}}}, "expected 0 beside several people"),
    ],
)
def test_settings_of_one_participant_are_refused_beside_people(changes, said):
    with pytest.raises(ConfigurationError, match=said):
        protocol(ADA, BO, **changes)


@pytest.mark.parametrize(
    "wrong",
    [{"name": "Ada Smith"}, {"name": ""}, {"good": ""}, {"graded": ("x", "c", "v", "b", "n")}],
    ids=str,
)
def test_a_person_without_a_code_or_with_half_their_keys_is_refused(wrong):
    with pytest.raises(ValueError, match=r"code|needs either good and bad"):
        msgspec.structs.replace(ADA, **wrong)


def test_a_protocol_of_one_is_written_as_before_there_were_people():
    plain = to_plain(DEFAULTS["tetris"])
    assert "people" not in plain
    assert "graded" not in plain["keys"]
