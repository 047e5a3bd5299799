import unicodedata

from hypothesis import given
from hypothesis import strategies as st

from core.system.foreign_text import LONGEST, printable, printable_lines


def test_control_characters_and_bidirectional_overrides_are_shown_as_escapes():
    assert printable("a\x1b]0;owned\x07b") == r"a\x1b]0;owned\x07b"
    assert printable("\x9b2J") == r"\x9b2J"  # the one-byte form of the same command
    assert printable("one\r\ntwo\u2028three") == r"one\x0d\x0atwo\u2028three"
    assert printable("user\u202egnp.exe") == r"user\u202egnp.exe"
    assert printable("\ud800") == r"\ud800"


def test_letters_of_any_script_stay_as_they_are():
    for text in ("P01", "Prüfling", "受試者", "участник", "é", "👩\u200d🔬"):
        assert printable(text) == text


def test_long_texts_are_cut_and_their_length_is_said():
    assert printable("x" * LONGEST) == "x" * LONGEST
    assert printable("x" * 1_000_000) == "x" * LONGEST + "... (1,000,000 characters)"
    assert printable("x" * 1000, longest=None) == "x" * 1000


def test_lines_stay_lines():
    assert printable_lines("a\nb\x1b[2J\n") == "a\nb\\x1b[2J\n"


@given(st.text())
def test_nothing_that_a_terminal_obeys_is_left(text):
    shown = printable(text, longest=None)
    assert not any(unicodedata.category(sign) in ("Cc", "Cs", "Zl", "Zp") for sign in shown)
    assert "\u202e" not in shown
