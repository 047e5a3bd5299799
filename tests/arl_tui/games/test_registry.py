"""Screens are found by the game's name, and a game without any says so."""

import subprocess
import sys

import pytest

from arl_tui.games import registry
from arl_tui.games.registry import BUILT_IN, GameScreens, screens_called, screens_of
from core.plugins import GameError
from core.session.protocol import DEFAULTS


@pytest.mark.parametrize("name", BUILT_IN)
def test_every_game_of_the_program_has_screens_of_its_own_name(name: str) -> None:
    screens = screens_of(DEFAULTS[name])
    assert isinstance(screens, GameScreens)
    assert screens.name == name
    assert screens.words.step
    assert screens.demo(None).game == name
    assert "slower" in screens.slower(DEFAULTS[name].screen)


def test_a_game_without_screens_is_named_with_what_can_be_done(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(registry, "_installed", dict)
    with pytest.raises(GameError, match="'corridor' has no screens: simulate it"):
        screens_called("corridor")


def test_screens_of_another_package_are_found_or_refused_with_the_reason(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(registry, "_installed", lambda: {"corridor": "tests.games.corridor:PLUGIN"})
    with pytest.raises(GameError, match="not an instance of a subclass"):
        screens_called("corridor")
    monkeypatch.setattr(registry, "_installed", lambda: {"corridor": "no_such_module:SCREENS"})
    with pytest.raises(GameError, match="cannot be loaded"):
        screens_called("corridor")


def test_words_of_a_game_need_neither_widgets_nor_compiled_code() -> None:
    code = (
        "import sys; from arl_tui.games.registry import BUILT_IN, words_of; list(map(words_of, BUILT_IN)); "
        "print([name for name in ('numba', 'textual', 'gymnasium') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"
