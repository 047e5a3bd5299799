"""Keys of other keyboard layouts: which Latin letter stands on the key that sent another one.

A terminal sends characters, not keys. Where the keyboard is set to another alphabet, the key of `j` sends
another letter, and a participant's feedback would be lost. The tables say which Latin letter the same key
sends in the US layout. Why each alphabet has the layout it has here: `docs/decisions/keyboard-layouts.md`.
"""

import unicodedata
from dataclasses import dataclass

_LATIN = "qwertyuiopasdfghjklzxcvbnm"


@dataclass(frozen=True, slots=True)
class Reading:
    """What a character of another layout stands for."""

    letter: str
    """The Latin letter on the same key, a-z."""
    layout: str
    """Name of the layout by which it was found."""


@dataclass(frozen=True, slots=True)
class _Layout:
    name: str
    letters: str
    """What the keys of `_LATIN` send, in that order; a space where it is not a letter of this alphabet."""
    q: str = ""
    """Textual's name of what the key of q sends, where that is a punctuation mark."""


# The first layout that has a character decides. Names of scripts are Unicode's.
_LAYOUTS: tuple[_Layout, ...] = (
    _Layout("Russian", "йцукенгшщзфывапролдячсмить"),
    _Layout("Ukrainian", "йцукенгшщзфівапролдячсмить"),
    _Layout("Belarusian", "йцукенгшўзфывапролдячсміть"),
    _Layout("Serbian", "љњертзуиопасдфгхјклѕџцвбнм"),
    _Layout("Hebrew", "  קראטוןםפשדגכעיחלךזסבהנמצ", "slash"),
    _Layout("Greek", " ςερτυθιοπασδφγηξκλζχψωβνμ", "semicolon"),
    _Layout("Arabic", "ضصثقفغعهخحشسيبلاتنمئءؤر ىة"),
    _Layout("Korean", "ㅂㅈㄷㄱㅅㅛㅕㅑㅐㅔㅁㄴㅇㄹㅎㅗㅓㅏㅣㅋㅌㅊㅍㅠㅜㅡ"),
    _Layout("Georgian", "ქწერტყუიოპასდფგჰჯკლზხცვბნმ"),
)
_OTHER_CYRILLIC = frozenset({"bg", "mn"})
"""Languages whose usual layouts put other Cyrillic letters on the same keys.

Read by Russian's layout, good could become bad.
"""


def _table() -> dict[str, Reading]:
    found: dict[str, Reading] = {}
    for layout in _LAYOUTS:
        for letter, sent in zip(_LATIN, layout.letters, strict=True):
            if sent != " ":
                found.setdefault(sent, Reading(letter, layout.name))
    return found


_READINGS = _table()
_AT_Q = {layout.q: layout.name for layout in _LAYOUTS if layout.q}


def possible_readings(key: str) -> frozenset[Reading]:
    """Return all that a key can stand for, whatever was typed before and whatever the participant's language
    is.
    """
    if key in _AT_Q:
        return frozenset({Reading("q", _AT_Q[key])})
    reading = None if len(key) != 1 or key.isascii() else KeyReader().read(key)
    return frozenset() if reading is None else frozenset({reading})


class KeyReader:
    """Reads the keys of one keyboard.

    It remembers the alphabet of the last letter, to know what a punctuation mark stands for.
    """

    def __init__(self, language: str = "") -> None:
        """Begin with the Latin layout.

        Args:
            language: the participant's language by ISO 639 ("bg"), where it is known; "" where it is not.
        """
        self._cyrillic = language.lower() not in _OTHER_CYRILLIC
        self._alphabet = ""

    def read(self, key: str) -> Reading | None:
        """Return what a key of another layout stands for; None for Latin, named and unknown keys.

        Args:
            key: the terminal's name of it: a character, or a name as "space" or "slash".
        """
        if key in _AT_Q:
            return Reading("q", self._alphabet) if self._alphabet == _AT_Q[key] else None
        if len(key) != 1:
            return None
        if key.isascii():
            self._alphabet = "" if key.isalpha() else self._alphabet
            return None
        reading = self._of_letter(key.lower())
        if reading is not None:
            self._alphabet = reading.layout
        return reading

    def _of_letter(self, key: str) -> Reading | None:
        plain = unicodedata.normalize("NFKC", key)
        if len(plain) == 1 and plain.isascii() and plain.isalpha():
            return Reading(plain.lower(), "full-width")
        if not self._cyrillic and unicodedata.name(key, "").startswith("CYRILLIC"):
            return None
        return _READINGS.get(key)


def alphabet_of(key: str) -> str:
    """Return the alphabet of a letter that is not Latin: "Cyrillic", "Thai"; "" for other keys.

    Args:
        key: one character.
    """
    if len(key) != 1 or key.isascii() or unicodedata.category(key)[0] not in "LM":
        return ""
    alphabet = unicodedata.name(key, "").split(" ")[0]
    return "" if alphabet in ("LATIN", "") else alphabet.capitalize()
