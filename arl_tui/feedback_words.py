"""What a press says, in words of participants and their language: for every screen that names it."""

from collections.abc import Mapping

from arl_tui.language import later, tr
from core.feedback.keys import KeyConfig

_WORDS = {
    2.0: later("very good"),
    1.0: later("good"),
    0.0: later("neither"),
    -1.0: later("bad"),
    -2.0: later("very bad"),
}
_SIGNS = {2.0: "++", 1.0: "+", 0.0: "0", -1.0: "-", -2.0: "--"}


def word_of(value: float) -> str:
    """Return what a press of this value says: "good"; "good (3)" for one that no key here says."""
    return tr(_WORDS[value]) if value in _WORDS else f"{tr(kind_of(value))} ({value:g})"


def kind_of(value: float) -> str:
    """Return "good", "bad" or "neither": the kind, in English whatever the language."""
    return "good" if value > 0 else "bad" if value < 0 else "neither"


def short_words(keys: KeyConfig) -> list[tuple[str, str]]:
    """Return each feedback key with a short word: good and bad, or signs where feedback is graded.

    The good key comes first; grades come in their order, the worst first.
    """
    if keys.graded:
        return [(key, _SIGNS[value]) for key, value in keys.meanings.items()]
    return [(keys.good, tr("good")), (keys.bad, tr("bad"))]


def told(said: Mapping[float, int], keys: KeyConfig) -> str:
    """Return how often each key was pressed: "good 3, bad 1"; of grades the worst first.

    Args:
        said: number of presses by value.
        keys: which values there are.
    """
    values = list(keys.meanings.values())
    if not keys.graded:
        values.reverse()
    return ", ".join(f"{word_of(value)} {said.get(value, 0)}" for value in values)
