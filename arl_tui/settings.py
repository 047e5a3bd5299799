"""What a user sets once for all sessions on this computer: `settings.toml` in the folder of `arl_tui.home`.

It holds what no study depends on: the program's own keys, and the language of sessions that have no protocol
file. A study and a protocol file say for themselves which language they are in.
"""

from pathlib import Path
from typing import Annotated

import msgspec

from arl_tui.home import home
from arl_tui.language import OWN_KEYS
from arl_tui.own_keys import wrong_keys
from core.configuration.fields import text
from core.configuration.reading import ConfigurationError, Problem, read
from core.session.protocol import Language
from core.session.protocol_file import located, read_toml

NAME = "settings.toml"
ADVICE = "Mend the file, or remove it; docs/how-to/language-and-keys.md has its keys."
Letter = Annotated[str, text("one lower-case letter a-z")]


class OwnKeys(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The program's own keys; "" leaves one as it is in the language in use."""

    pause: Letter = ""
    help: Letter = ""
    stop: Letter = ""
    yes: Letter = ""
    no: Letter = ""
    stop_yes: Letter = ""
    """Yes to the question whether to stop."""
    back: Letter = ""
    new: Letter = ""
    """A new game, a new session."""
    continue_: Annotated[Letter, msgspec.Meta(description="continue")] = msgspec.field(
        default="", name="continue"
    )


class Settings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The file, completely."""

    language: Language = "en"
    """Of sessions without a protocol file, calibrations, practice and demonstrations."""
    keys: OwnKeys = OwnKeys()

    @property
    def changed_keys(self) -> dict[str, str]:
        """The keys that are set, by name."""
        given: dict[str, str] = msgspec.to_builtins(self.keys)
        return {name: key for name, key in given.items() if key}


def settings_file() -> Path:
    """Return where the settings are; the file need not exist."""
    return home() / NAME


def read_settings(path: Path) -> Settings:
    """Return the settings in a file; the defaults where there is none.

    Raises:
        ValueError: the file cannot be used; the message says where, why, and what to do.
    """
    if not path.exists():
        return Settings()
    written, given = read_toml(path, what="the settings", advice=ADVICE)
    try:
        settings = read(given, Settings(), to_run=True)
    except ConfigurationError as error:
        raise ValueError(located(path, written, error.problems, advice=ADVICE)) from error
    reason = wrong_keys({**OWN_KEYS, **settings.changed_keys})
    if reason:
        raise ValueError(located(path, written, [Problem(("keys",), reason)], advice=ADVICE))
    return settings
