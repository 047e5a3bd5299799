"""Keys of other layouts: which Latin letter stands on them, and what counts."""

import pytest

from core.events import KeyPressed
from core.feedback.keys import KeyConfig, PressGate
from core.feedback.layouts import _LATIN, _LAYOUTS, KeyReader, alphabet_of
from core.numerics.clock import NS_PER_S

# What the keys of j, f, p, h, u, y and n send, from the keyboards' own pictures.
SENT = {
    "Russian": "оазргнт",
    "Hebrew": "חכפיוטמ",
    "Greek": "ξφπηθυν",
    "Arabic": "تبحاعغى",
    "Georgian": "ჯფპჰუყნ",
    "Korean": "ㅓㄹㅔㅗㅕㅛㅜ",
    "full-width": "ｊｆｐｈｕｙｎ",
}


@pytest.mark.parametrize("layout", SENT)
def test_the_session_s_keys_are_found_under_every_layout(layout: str) -> None:
    reader = KeyReader()
    for sent, letter in zip(SENT[layout], "jfphuyn", strict=True):
        reading = reader.read(sent)
        assert reading is not None, sent
        assert (reading.letter, reading.layout) == (letter, layout)


def test_every_layout_names_a_key_once() -> None:
    for layout in _LAYOUTS:
        assert len(layout.letters) == len(_LATIN)
        letters = layout.letters.replace(" ", "")
        assert len(set(letters)) == len(letters), layout.name


@pytest.mark.parametrize(
    "key", ["j", "J", "7", "?", "space", "f1", "ctrl+q", "é", "ö", "ß", "ก", "left_shift"]
)
def test_latin_named_and_unknown_keys_stand_for_themselves(key: str) -> None:
    assert KeyReader().read(key) is None


def test_capital_letters_are_read_as_small_ones() -> None:
    reading = KeyReader().read("О")
    assert reading is not None
    assert reading.letter == "j"


def test_a_mark_where_q_would_be_is_q_only_behind_a_letter_of_that_alphabet() -> None:
    reader = KeyReader()
    assert reader.read("slash") is None
    reader.read("ח")
    reading = reader.read("slash")
    assert reading is not None
    assert (reading.letter, reading.layout) == ("q", "Hebrew")
    assert reader.read("semicolon") is None
    reader.read("j")
    assert reader.read("slash") is None


def test_where_good_and_bad_would_be_exchanged_nothing_is_guessed() -> None:
    # The Bulgarian layout has this letter on the key of f, the Russian one on that of j.
    assert KeyReader(language="bg").read("о") is None
    assert KeyReader(language="bg").read("ξ") is not None


@pytest.mark.parametrize(
    ("key", "alphabet"),
    [("ж", "Cyrillic"), ("ก", "Thai"), ("א", "Hebrew"), ("j", ""), ("ö", ""), ("7", ""), ("f1", "")],
)
def test_a_letter_tells_its_alphabet(key: str, alphabet: str) -> None:
    assert alphabet_of(key) == alphabet


def test_a_press_of_another_layout_counts_and_is_recorded_raw_with_how_it_was_read() -> None:
    gate = PressGate(KeyConfig())
    gate.episode_started()
    [good] = gate.judge("о", NS_PER_S)
    [bad] = gate.judge("а", 2 * NS_PER_S)
    [other] = gate.judge("ж", 3 * NS_PER_S)
    [latin] = gate.judge("j", 4 * NS_PER_S)
    assert [(press.key, press.value, press.verdict) for press in (good, bad, other)] == [
        ("о", 1.0, "accepted"),
        ("а", -1.0, "accepted"),
        ("ж", None, "other"),
    ]
    assert (good.read_as, good.layout) == ("j", "Russian")
    assert (latin.read_as, latin.layout) == ("", "")


def test_the_retract_key_of_another_layout_takes_a_press_back() -> None:
    gate = PressGate(KeyConfig())
    gate.episode_started()
    list(gate.judge("ξ", NS_PER_S))
    pressed, retracted = gate.judge("θ", 2 * NS_PER_S)
    assert isinstance(pressed, KeyPressed)
    assert retracted.press == 0
