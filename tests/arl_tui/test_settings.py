"""Settings of this computer: read strictly; keys that are changed hold, are shown, and are noted."""

from pathlib import Path

import click
import msgspec
import pytest

from arl_tui import language
from arl_tui.commands.play import in_language, refuse_clash
from arl_tui.home import VARIABLE
from arl_tui.screens.covers import PauseScreen
from arl_tui.session_app import ArlApp
from arl_tui.settings import NAME, Settings, read_settings
from core.events import StopAsked
from core.feedback.keys import KeyConfig
from core.recording.schema import to_plain
from core.session.protocol import Protocol, ScreenConfig
from core.session.protocol_reading import protocol_from
from tests.arl_tui.driving import app_for, begin, recorded, settle, text_of
from tests.arl_tui.fakes import FakeLink


@pytest.fixture
def no_gaps(monkeypatch: pytest.MonkeyPatch) -> None:
    """A busy machine must not pause the session by itself."""
    monkeypatch.setattr("arl_tui.app.gaps.GapWatch.look", lambda self: None)


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv(VARIABLE, str(tmp_path))
    return tmp_path


def written(folder: Path, text: str) -> Path:
    (folder / NAME).write_text(text)
    return folder / NAME


def test_without_a_file_all_is_as_it_comes(tmp_path: Path) -> None:
    assert read_settings(tmp_path / NAME) == Settings()
    assert Settings().changed_keys == {}


def test_keys_and_language_are_read(tmp_path: Path) -> None:
    settings = read_settings(written(tmp_path, 'language = "de"\n[keys]\npause = "w"\ncontinue = "k"\n'))
    assert settings.language == "de"
    assert settings.changed_keys == {"pause": "w", "continue": "k"}


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("langauge = 'de'", "did you mean `language`"),
        ("language = 'fr'", "de"),
        ("[keys]\npuase = 'w'", "did you mean `pause`"),
        ("[keys]\npause = 'h'", "pause and help are both 'h'"),
        ("[keys]\npause = 'W'", "one lower-case letter"),
        ("[keys\n", "not a TOML file"),
    ],
)
def test_what_cannot_be_is_refused_with_file_and_reason(tmp_path: Path, text: str, reason: str) -> None:
    path = written(tmp_path, text)
    with pytest.raises(ValueError, match=r"settings\.toml") as caught:
        read_settings(path)
    assert reason in str(caught.value)
    assert "docs/how-to/language-and-keys.md has its keys" in str(caught.value)
    assert "arl protocol" not in str(caught.value)


def test_a_key_for_feedback_is_no_key_of_the_program(home: Path) -> None:
    written(home, "[keys]\nstop = 'x'\n")
    refuse_clash(Protocol())
    with pytest.raises(click.ClickException, match="'x' is stop in the settings and a key for feedback"):
        refuse_clash(Protocol(keys=KeyConfig(good="x")))


@pytest.mark.parametrize(
    ("asked", "written_protocol", "found"),
    [
        (None, False, "de"),  # the settings
        ("en", False, "en"),
        (None, True, "en"),  # a file says it for everybody
        ("de", True, "de"),
    ],
)
def test_who_says_the_language(home: Path, asked: str | None, written_protocol: bool, found: str) -> None:
    written(home, "language = 'de'\n")
    assert in_language(Protocol(), asked, written=written_protocol).screen.language == found


def test_lang_changes_nothing(home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LANG", "de_DE.UTF-8")
    assert in_language(Protocol(), None, written=False).screen.language == "en"


async def test_a_changed_key_pauses_is_shown_and_is_noted_in_the_header(
    home: Path, no_gaps: None, protocol: Protocol, link: FakeLink, tmp_path: Path
) -> None:
    language.change_keys({"pause": "w", "stop_yes": "k"})
    app: ArlApp = app_for(protocol, link, tmp_path / "recordings")
    async with app.run_test(size=(80, 24)) as pilot:
        await begin(pilot, link, protocol, steps=1)
        await pilot.press("p")
        await settle(pilot)
        assert not isinstance(app.screen, PauseScreen)
        await pilot.press("w")
        await settle(pilot)
        assert isinstance(app.screen, PauseScreen)
        assert " W " in text_of(app)
        await pilot.press("w", "q", "y")
        await settle(pilot)
        assert not any(isinstance(message, StopAsked) for message in link.sent)
        await pilot.press("k")
        await settle(pilot)
        assert any(isinstance(message, StopAsked) for message in link.sent)
    text = next((tmp_path / "recordings").glob("*.jsonl")).read_text().partition("\n")[0]
    assert '"own_keys":"pause w, stop_yes k"' in text


async def test_a_german_session_says_so_in_its_header_and_speaks_german(
    no_gaps: None, protocol: Protocol, link: FakeLink, tmp_path: Path
) -> None:
    protocol = msgspec.structs.replace(
        protocol, screen=msgspec.structs.replace(protocol.screen, language="de")
    )
    app = app_for(protocol, link, tmp_path)
    async with app.run_test(size=(80, 24)) as pilot:
        await begin(pilot, link, protocol, steps=1)
        await pilot.press("h")
        await settle(pilot)
        assert "Volle Reihen verschwinden" in text_of(app)
        await pilot.press("h", "q")
        await settle(pilot)
        assert "Beenden mit" in text_of(app)
        await pilot.press("j")  # good, and no yes
        await settle(pilot)
        assert not any(isinstance(message, StopAsked) for message in link.sent)
        await pilot.press("n")
    header = recorded(tmp_path).header
    assert header.protocol["screen"]["language"] == "de"
    assert protocol_from(header.protocol).screen.language == "de"


def test_in_english_nothing_new_is_recorded() -> None:
    assert "language" not in to_plain(Protocol())["screen"]
    german = Protocol(screen=ScreenConfig(language="de"))
    assert to_plain(german)["screen"]["language"] == "de"
    assert protocol_from(to_plain(Protocol())) == Protocol()
