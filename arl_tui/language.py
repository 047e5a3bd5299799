"""The words on participants' screens in their language: English in the code, other languages in `locale`.

Every text that a participant reads goes through `tr` or `trn`, which look it up in the catalogue of the
language in use (gettext) and fill its placeholders. A text that is made before the language is known is
marked with `later`, and goes through `tr` when it is shown.
"""

from collections.abc import Mapping
from gettext import GNUTranslations, NullTranslations
from pathlib import Path
from string import Formatter
from types import MappingProxyType
from typing import get_args

from core.session.protocol import Language

LANGUAGES: tuple[str, ...] = get_args(Language)
"""Languages by ISO 639; the first one is that of the code, and needs no catalogue."""
CATALOGUES = Path(__file__).parent / "locale"

OWN_KEYS: Mapping[str, str] = {
    "pause": "p",
    "help": "h",
    "stop": "q",
    "yes": "y",
    "no": "n",
    "stop_yes": "y",
    "back": "b",
    "continue": "c",
    "new": "n",
}
"""What the program's own keys do, and the key of each in English. Keys for feedback are the protocol's."""
KEYS_OF_LANGUAGE: Mapping[str, Mapping[str, str]] = {
    # "j" is the key for good: it must not end a session on the page that asks whether to stop.
    "de": {"yes": "j", "stop_yes": "b", "back": "z", "continue": "f"},
}
"""Where a language has other keys of its own."""
FIXED_KEYS = ("enter", "space", "escape", "f1", "skip", "force_stop")
"""Keys that no setting changes, by the name that texts have for them."""


def later(text: str) -> str:
    """Mark a text for the catalogue; `tr` translates it when it is shown."""
    return text


def later_n(one: str, many: str) -> tuple[str, str]:
    """Mark two texts, for one and for several, for the catalogue; `trn` chooses when they are shown."""
    return one, many


_NAMES = {
    "space": later("Space"),
    "enter": later("Enter"),
    "escape": later("Esc"),
    "ctrl": later("Ctrl"),
    "pagedown": later("Page down"),
    "pageup": later("Page up"),
}
_FIXED = {
    "enter": "enter",
    "space": "space",
    "escape": "escape",
    "f1": "f1",
    "skip": "ctrl+n",
    "force_stop": "ctrl+q",
}


class _InUse:
    """The language of this process and the keys that texts name."""

    code: str = LANGUAGES[0]
    catalogue: NullTranslations = NullTranslations()
    keys: Mapping[str, str] = OWN_KEYS
    changed: Mapping[str, str] = MappingProxyType({})


def change_keys(changed: Mapping[str, str]) -> None:
    """Use other keys of the program's own than those of the language, from the next `use` on.

    Args:
        changed: some of `OWN_KEYS`.
    """
    _InUse.changed = dict(changed)


def use(code: str) -> None:
    """Show all words from now on in a language.

    Args:
        code: one of `LANGUAGES`.

    Raises:
        ValueError: there is no such language.
    """
    if code not in LANGUAGES:
        raise ValueError(f"there is no language {code!r}: choose one of {', '.join(LANGUAGES)}")
    _InUse.catalogue = catalogue_of(code)
    _InUse.code = code
    _InUse.keys = {**OWN_KEYS, **KEYS_OF_LANGUAGE.get(code, {}), **_InUse.changed}


def in_use() -> str:
    """Return the language in use."""
    return _InUse.code


def changed_keys() -> Mapping[str, str]:
    """Return the program's own keys that this user has changed, by name."""
    return _InUse.changed


def keys_in_use() -> Mapping[str, str]:
    """Return the program's own keys by name, as they are in this language and with this user's settings."""
    return _InUse.keys


def catalogue_of(code: str) -> NullTranslations:
    """Return the texts of a language; those of the code itself need none.

    Raises:
        FileNotFoundError: the program was installed without its catalogues.
    """
    if code == LANGUAGES[0]:
        return NullTranslations()
    with (CATALOGUES / code / "LC_MESSAGES" / "arl.mo").open("rb") as file:
        return GNUTranslations(file)


def tr(text: str, **values: object) -> str:
    """Return a text in the language in use.

    Args:
        text: English, with placeholders; `{key_stop}` and the like stand for keys as they are printed on the
            keyboard, in markup.
        values: by the names of the other placeholders.
    """
    return _filled(_InUse.catalogue.gettext(text), values) if text else ""


def trn(one: str, many: str, n: float, **values: object) -> str:
    """Return one of two texts by a number, which they may show as `{n}`; see `tr`.

    Args:
        one: for exactly one.
        many: for any other number.
        n: the number.
        values: by the names of the other placeholders.
    """
    whole = int(n) if n == int(n) else 2
    return _filled(_InUse.catalogue.ngettext(one, many, whole), {"n": n, **values})


def _filled(text: str, values: Mapping[str, object]) -> str:
    if "{" not in text:
        return text
    named = [name for _, name, _, _ in Formatter().parse(text) if name]
    keys = {name: cap(key_for(name.removeprefix("key_"))) for name in named if name.startswith("key_")}
    return text.format(**keys, **values)


# --- keys ---------------------------------------------------------------------------------------------------


def key_for(action: str) -> str:
    """Return the key that does something, by Textual's name of it.

    Args:
        action: one of `OWN_KEYS` or `FIXED_KEYS`.
    """
    return _FIXED.get(action) or _InUse.keys[action]


def key_name(key: str) -> str:
    """Return a key as it is printed on the keyboard.

    Args:
        key: Textual's name of it: "p", "space", "ctrl+q".
    """
    *before, last = key.split("+")
    parts = [tr(_NAMES[part]) if part in _NAMES else part.capitalize() for part in before]
    return "+".join([*parts, tr(_NAMES[last]) if last in _NAMES else last.upper()])


def cap(key: str) -> str:
    """Return a key as it is printed on the keyboard, in markup."""
    return f"[reverse] {key_name(key)} [/]"


def bold_cap(key: str) -> str:
    """Return a key that stands out from a text, in markup."""
    return f"[reverse b] {key_name(key)} [/]"
