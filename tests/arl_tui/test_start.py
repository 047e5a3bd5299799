"""The home page leads to the real commands, F1 helps on every page, and no session has a palette."""

import os
from pathlib import Path

import pytest
from click.testing import CliRunner
from textual.command import CommandPalette
from textual.pilot import Pilot
from textual.screen import Screen
from textual.widgets import Input, OptionList

from arl_tui.app.key_help import rows_of
from arl_tui.cli import main
from arl_tui.commands import start
from arl_tui.session_app import ArlApp
from arl_tui.start.app import HomeApp
from arl_tui.start.entries import HOME, command_line, sessions_in, studies_in
from arl_tui.study.monitor import Monitor
from arl_tui.study.pages import DeclinePage, StopPage
from arl_tui.viewer.app import ViewerApp
from tests.arl_tui.test_words_on_screens import PAGES, Shown, drawn


async def chosen(folder: Path, *keys: str) -> tuple[str, ...] | None:
    app = HomeApp(folder)
    async with app.run_test(size=(80, 24)) as pilot:
        for key in keys:
            await pilot.press(key)
            await pilot.pause()
        return app.return_value


@pytest.mark.parametrize(
    ("keys", "arguments"),
    [
        (["enter", "enter", "enter"], ("play", "tetris", "--participant", "P00")),
        (["enter", "down", "enter", "P", "7", "enter"], ("play", "keepaway", "--participant", "P7")),
        (["down", "enter", "enter"], ("calibrate", "--participant", "P00")),
        (["down", "down", "down", "enter"], ("recordings",)),
        (["down"] * 5 + ["enter"], ("practice",)),
        (["down"] * 7 + ["enter"], ("doctor",)),
        (["q"], None),
        (["enter", "escape", "escape"], None),
        (["down", "enter", "escape", "q"], None),
    ],
)
async def test_each_entry_leads_to_its_command(tmp_path: Path, keys: list[str], arguments) -> None:
    assert await chosen(tmp_path, *keys) == arguments


async def test_a_session_is_chosen_from_the_newest_on(tmp_path: Path) -> None:
    for age, name in enumerate(("old.jsonl", "new[1].jsonl")):
        (tmp_path / name).write_text("")
        os.utime(tmp_path / name, (age, age))
    (tmp_path / "notes.txt").write_text("")
    assert [entry.title for entry in sessions_in(tmp_path)] == ["new[1].jsonl", "old.jsonl"]
    keys = ["down"] * 4 + ["enter", "enter"]
    assert await chosen(tmp_path, *keys) == ("watch", str(tmp_path / "new[1].jsonl"))


async def test_a_study_is_chosen_from_this_folder_and_those_below(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "{x}").mkdir()
    (tmp_path / "{x}" / "study.toml").write_text("")
    assert [entry.title for entry in studies_in(Path())] == ["{x}/study.toml", "A new one"]
    assert await chosen(tmp_path, "down", "down", "enter", "enter", "down", "enter") == (
        "study",
        "status",
        "{x}/study.toml",
        "--watch",
    )


async def test_what_is_no_code_is_not_taken(tmp_path: Path) -> None:
    app = HomeApp(tmp_path)
    async with app.run_test(size=(80, 24)) as pilot:
        await pilot.press("enter", "enter")
        await pilot.pause()
        app.screen.query_one(Input).value = "Jane Doe"
        await pilot.press("enter")
        await pilot.pause()
        assert "This is no code" in drawn(app)
        assert app.return_value is None


async def test_the_command_line_of_the_marked_entry_is_shown(tmp_path: Path) -> None:
    app = HomeApp(tmp_path)
    async with app.run_test(size=(80, 24)) as pilot:
        await pilot.press("down")
        await pilot.pause()
        assert "arl calibrate ..." in drawn(app)
        assert app.screen.query_one(OptionList).has_focus


def test_every_command_of_the_home_page_exists() -> None:
    for entry in HOME:
        result = CliRunner().invoke(main, [entry.arguments[0], "--help"])
        assert result.exit_code == 0, entry


def test_a_command_line_is_quoted() -> None:
    assert command_line(("watch", "my file.jsonl")) == "arl watch 'my file.jsonl'"


def test_without_a_terminal_the_help_is_printed() -> None:
    result = CliRunner().invoke(main, [])
    assert "Commands:" in result.output


def test_it_comes_back_after_a_command_until_it_is_left(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    results = iter([("doctor",), None])
    ran = []
    monkeypatch.setattr(HomeApp, "run_in_terminal", lambda self: next(results))
    monkeypatch.setattr(start, "run", lambda arguments: ran.append(arguments) or 3)
    monkeypatch.setattr(start, "wait_for_enter", lambda: True)
    start.run_home()
    assert ran == [("doctor",)]
    told = capsys.readouterr()
    assert "$ arl doctor" in told.out
    assert "status 3" in told.err


# --- F1 -----------------------------------------------------------------------------------------------------


async def test_f1_helps_on_every_page_and_goes_back() -> None:
    without = []
    app = Shown()
    async with app.run_test(size=(100, 40)) as pilot:
        for name, make in PAGES.items():
            if name == "small-window":
                continue  # it leaves by itself here
            page = make()
            await app.push_screen(page)
            await pilot.press("f1")
            await pilot.pause()
            # The help page itself goes back at F1.
            if name.startswith("help"):
                if app.screen is page:
                    without.append(name)
                    app.pop_screen()
                continue
            if app.screen is page:
                without.append(name)
            else:
                await pilot.press("f1")
                await pilot.pause()
            assert app.screen is page, name
            app.pop_screen()
    assert without == []


@pytest.mark.parametrize("page", [lambda: StopPage("P01"), DeclinePage])
async def test_the_help_names_the_keys_of_the_page_as_they_are_bound(page) -> None:
    app = Shown(language="de")
    async with app.run_test(size=(80, 24)) as pilot:
        await app.push_screen(page())
        await pilot.pause()
        rows = {meaning: keys for keys, meaning in rows_of(app.screen)}
    assert rows.get("Die Studie beenden", "B") == "B"
    assert rows.get("Zurück zu den Aussagen", "Z, Esc") == "Z, Esc"
    assert len(rows) >= 2


# --- palette ------------------------------------------------------------------------------------------------


async def test_the_palette_finds_an_entry_of_the_home_page(tmp_path: Path) -> None:
    app = HomeApp(tmp_path)
    async with app.run_test(size=(80, 24)) as pilot:
        await pilot.press("ctrl+p")
        await pilot.pause()
        assert isinstance(app.screen, CommandPalette)
        await pilot.press(*"doctor")
        await until_results(pilot)
        await pilot.press("enter")
        await pilot.pause(0.2)
        if app.return_value is None:
            await pilot.press("enter")
            await pilot.pause(0.2)
        assert app.return_value == ("doctor",)


async def until_results(pilot: Pilot) -> None:
    for _ in range(100):
        await pilot.pause(0.05)
        if "arl doctor" in drawn(pilot.app):
            return
    raise AssertionError(drawn(pilot.app))


def test_apps_outside_of_sessions_have_a_palette_and_a_session_has_none() -> None:
    assert HomeApp.ENABLE_COMMAND_PALETTE
    assert ViewerApp.ENABLE_COMMAND_PALETTE
    assert Monitor.ENABLE_COMMAND_PALETTE
    assert not ArlApp.ENABLE_COMMAND_PALETTE
    assert not Shown.ENABLE_COMMAND_PALETTE


async def test_no_palette_opens_on_a_participants_page() -> None:
    app = Shown()
    async with app.run_test(size=(80, 24)) as pilot:
        page: Screen = PAGES["stop"]()
        await app.push_screen(page)
        await pilot.press("ctrl+p")
        await pilot.pause()
        assert app.screen is page


@pytest.mark.parametrize("size", [(80, 24), (120, 40)], ids=str)
def test_the_home_page_looks_as_it_did(snap_compare, size: tuple[int, int]) -> None:
    assert snap_compare(HomeApp(Path("/home/lab/arl/recordings")), terminal_size=size)


async def test_the_home_page_marks_what_was_chosen_last(tmp_path: Path) -> None:
    app = HomeApp(tmp_path, marked=3)
    async with app.run_test(size=(80, 24)) as pilot:
        await pilot.pause()
        assert app.screen.query_one(OptionList).highlighted == 3
        await pilot.press("down", "enter")  # look at a session: there is none
        await pilot.pause()
        await pilot.press("escape")
        await pilot.pause()
        assert app.screen.query_one(OptionList).highlighted == 4
    assert app.marked == 4
