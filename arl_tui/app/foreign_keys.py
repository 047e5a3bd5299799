"""What to tell a participant whose keyboard is set to another alphabet, where its keys cannot be read."""

import os

from arl_tui.language import later, tr
from core.feedback.layouts import alphabet_of

ALPHABETS = (later("Cyrillic"), later("Greek"), later("Hebrew"), later("Arabic"), later("Fullwidth"))
"""Those whose keyboards are most frequent; another one has the name that Unicode gives it."""
UNSURE = ("slash", "semicolon")
"""What the key of q sends under Hebrew and Greek: it may also be meant as it stands."""


class ForeignKeys:
    """Counts keys that look like another alphabet's, and says when it is time for advice."""

    def __init__(self) -> None:
        self._unsure = 0

    def advice(self, key: str, *, read: bool) -> str | None:
        """Return what to tell the participant after a key; None where there is nothing to tell.

        Args:
            key: a character, or the terminal's name of the key.
            read: it was read as a Latin letter (`core.feedback.layouts`), so nothing is lost.
        """
        alphabet = "" if read else alphabet_of(key)
        self._unsure = self._unsure + 1 if key in UNSURE and not read else 0
        if not alphabet and self._unsure != 2:
            return None
        if not alphabet:
            return tr("Is your keyboard set to other letters? Change it to English (Latin) letters")
        return tr(
            "Is your keyboard set to {alphabet} letters? Change it to English (Latin) letters",
            alphabet=tr(alphabet),
        )


def language_of_environment() -> str:
    """Return the language of this environment by ISO 639, as "bg"; "" where it is not said."""
    named = next((value for name in ("LC_ALL", "LC_CTYPE", "LANG") if (value := os.environ.get(name))), "")
    code = named.partition(".")[0].partition("_")[0]
    return "" if code in ("C", "POSIX") else code
