"""Watching a policy: keys, the panel, the end; and what may be asked for."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import click
import numpy as np
import pytest
from click.testing import CliRunner, Result
from textual.pilot import Pilot

from arl_tui.cli import main
from arl_tui.commands import watch as command
from arl_tui.palette import palette_for
from arl_tui.screens.watch import WatchApp, WatchScreen, summary
from arl_tui.widgets.pitch_ink import DETAILS
from core.keepaway.pitch import OUT, TAKEN, KeepawayConfig
from core.keepaway.simulator.policies import POLICIES
from core.numerics.clock import ManualClock
from tests.arl_tui.games.test_playback import Rolling

MS = 1_000_000


@pytest.fixture(autouse=True)
def _true_colour(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures must not depend on the terminal that the tests are run in."""
    monkeypatch.setattr(
        "arl_tui.screens.watch.palette_for",
        lambda name, *_system, **_no_color: palette_for(name, "truecolor"),
    )


class Playing:
    """An app at a moment of a clock that only the test moves."""

    def __init__(self, length: int = 50, **options) -> None:
        self.clock = ManualClock()
        self.screen = WatchScreen(
            "[b]Keepaway 3 against 2[/], 20 m x 20 m\nPolicy   rolling",
            length_m=20.0,
            width_m=20.0,
            detail="ascii",
            clock=self.clock,
            **options,
        )
        self.app = WatchApp(self.screen, lambda: Rolling(length))

    async def ready(self, pilot) -> None:
        """Wait until the match is ready."""
        while self.screen.playback is None:
            await pilot.pause(0.01)
        await pilot.pause()

    def pass_time(self, ms: int) -> None:
        self.clock.advance_ns(ms * MS)
        self.screen.draw()

    @property
    def pitch(self) -> str:
        pitch = self.screen.pitch
        return "\n".join(pitch.render_line(y).text for y in range(pitch.size.height))

    @property
    def panel(self) -> str:
        return str(self.screen.query_one("#panel").content)


@asynccontextmanager
async def running(size: tuple[int, int] = (80, 24), **options) -> AsyncIterator[tuple[Playing, Pilot[str]]]:
    """Run the app with a match that is ready; options as `Playing`."""
    playing = Playing(**options)
    async with playing.app.run_test(size=size) as pilot:
        await playing.ready(pilot)
        yield playing, pilot


async def test_it_says_that_it_is_getting_ready_and_begins_when_it_is():
    playing = Playing()
    async with playing.app.run_test(size=(80, 24)) as pilot:
        if playing.screen.playback is None:
            assert "Getting ready" in playing.pitch
        await playing.ready(pilot)
        assert "Getting ready" not in playing.pitch
        playing.pass_time(500)
        assert "0.5 s" in playing.pitch


async def test_space_stops_and_goes_on():
    async with running() as (playing, pilot):
        playing.pass_time(300)
        await pilot.press("space")
        assert "PAUSED" in playing.panel
        playing.pass_time(5_000)
        assert "0.3 s" in playing.pitch
        await pilot.press("space")
        playing.pass_time(400)
        assert "0.7 s" in playing.pitch
        assert "PAUSED" not in playing.panel


async def test_the_full_stop_goes_on_by_a_cycle():
    async with running() as (playing, pilot):
        await pilot.press("full_stop", "full_stop", "full_stop")
        assert "0.3 s" in playing.pitch
        assert "PAUSED" in playing.panel


async def test_plus_and_minus_change_the_speed():
    async with running() as (playing, pilot):
        await pilot.press("+")
        assert "x2" in playing.panel
        playing.pass_time(500)
        assert "1.0 s" in playing.pitch
        await pilot.press("-", "-", "-")
        assert "x0.25" in playing.panel
        playing.pass_time(400)
        assert "1.1 s" in playing.pitch


async def test_the_next_episode_can_be_asked_for():
    async with running() as (playing, pilot):
        await pilot.press("n")
        assert "Episode 2" in playing.pitch


async def test_each_press_of_d_draws_otherwise():
    async with running() as (playing, pilot):
        seen = []
        for _ in range(3):
            await pilot.press("d")
            seen.append(playing.screen.pitch.detail)
        assert seen == ["half", "braille", "ascii"]


async def test_the_panel_tells_what_the_policy_thinks_and_how_episodes_ended():
    async with running(length=3) as (playing, pilot):
        playing.pass_time(200)
        await pilot.press("full_stop")
        assert "0.3 s out" in playing.panel
        assert "Finished 1, mean 0.3 s" in playing.panel
        assert "K1 expects to keep the ball for" in playing.panel
        assert "Hold     0.3 s <" in playing.panel


async def test_help_explains_the_picture_while_time_stands_still():
    async with running() as (playing, pilot):
        playing.pass_time(200)
        await pilot.press("h")
        assert playing.app.screen is not playing.screen
        playing.pass_time(10_000)
        await pilot.press("space")
        await pilot.pause()
        assert playing.app.screen is playing.screen
        playing.pass_time(0)
        assert "0.2 s" in playing.pitch
        assert playing.screen.playback is not None
        assert not playing.screen.playback.paused


async def test_after_the_episodes_asked_for_it_leaves_and_says_what_was_seen():
    async with running(length=3, episodes=2) as (playing, pilot):
        for _ in range(2):
            playing.pass_time(300)
            playing.pass_time(1_500)
        await pilot.pause()
    assert playing.app.return_value == "2 episodes: mean 0.3 s; ball out 2, taken 0"


async def test_q_leaves_also_before_the_match_is_ready():
    playing = Playing()
    async with playing.app.run_test(size=(80, 24)) as pilot:
        await pilot.press("q")
    assert playing.app.return_value == "No episode was watched to its end."


async def test_what_went_wrong_while_getting_ready_ends_the_app():
    playing = Playing()

    def fail() -> Rolling:
        raise ValueError("no such thing")

    app = WatchApp(playing.screen, fail)
    async with app.run_test(size=(80, 24)) as pilot:
        while app.trouble is None:
            await pilot.pause(0.01)
    assert str(app.trouble) == "no such thing"


async def test_a_window_that_is_too_small_says_how_large_it_has_to_be():
    playing = Playing()
    async with playing.app.run_test(size=(60, 20)) as pilot:
        await pilot.pause()
        assert playing.app.screen is not playing.screen
        assert "80 columns and 24 lines" in "".join(
            str(s.content) for s in playing.app.screen.query("Static")
        )
        await pilot.resize_terminal(80, 24)
        await pilot.pause()
        assert playing.app.screen is playing.screen


async def test_whoever_cannot_have_a_larger_window_can_leave():
    playing = Playing()
    async with playing.app.run_test(size=(60, 20)) as pilot:
        await pilot.pause()
        await pilot.press("q")
        await pilot.pause()
    assert not playing.app.is_running


def test_the_end_is_told_in_a_line():
    assert summary([(10.0, OUT), (5.0, TAKEN)]) == "2 episodes: mean 7.5 s; ball out 1, taken 1"
    assert summary([(10.0, OUT)]) == "1 episode: mean 10.0 s; ball out 1, taken 0"


@pytest.mark.parametrize("size", [(80, 24), (120, 40)])
def test_watching_looks_as_it_did(snap_compare, size: tuple[int, int]):
    playing = Playing()
    playing.screen._detail = "braille"

    async def play(pilot) -> None:
        await playing.ready(pilot)
        playing.pass_time(350)
        await pilot.press("p")

    assert snap_compare(playing.app, terminal_size=size, run_before=play)


# --- the command --------------------------------------------------------------------------------------------


def run(*arguments: str) -> Result:
    return CliRunner().invoke(main, arguments)


def test_choices_written_out_for_help_are_those_there_are():
    assert set(command.BENCHMARKS) == set(POLICIES)
    assert command.DETAIL_NAMES == DETAILS


def test_without_a_terminal_it_says_so():
    result = run("watch", "keepaway")
    assert result.exit_code == 1
    assert "needs a terminal" in result.output


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (("--size", "big"), "'big': two numbers of metres such as 20x20"),
        (("--speed", "0"), "not in the range"),
        (("--keepers", "1"), "not in the range"),
        (("--vision", "none"), "is not one of 'exact', '360', '90'"),
        (("--detail", "fine"), "is not one of 'ascii', 'half', 'braille'"),
    ],
)
def test_what_cannot_be_is_refused_with_the_reason(arguments: tuple[str, ...], reason: str):
    result = run("watch", "keepaway", *arguments)
    assert result.exit_code == 2
    assert reason in result.output


def test_a_task_is_the_papers_but_for_what_is_given():
    asked = {"keepers": None, "takers": None, "size": None, "vision": None}
    assert command.task(None, **asked) == KeepawayConfig()
    assert command.task(None, **{**asked, "keepers": 4, "takers": 3, "size": (30.0, 25.0)}) == KeepawayConfig(
        n_keepers=4, n_takers=3, length_m=30.0, width_m=25.0
    )
    assert command.task(None, **{**asked, "vision": "exact"}).exact_state
    assert command.task(None, **{**asked, "vision": "90"}) == KeepawayConfig(view_angle_deg=90.0)
    with pytest.raises(click.ClickException, match="at least 10 m x 10 m"):
        command.task(None, **{**asked, "size": (5.0, 5.0)})


def test_a_policy_knows_its_own_task_and_no_other_number_of_players(tmp_path: Path):
    from core.keepaway.policy_file import SavedPolicy, save_policy
    from tests.core.keepaway.test_policy_file import HEADER, _weights

    save_policy(tmp_path / "k.npz", SavedPolicy(HEADER, _weights(1)))
    saved = command.read_policy(tmp_path / "k.npz")
    asked = {"keepers": None, "takers": None, "size": None, "vision": None}
    assert command.task(saved, **asked) == HEADER.task
    assert command.task(saved, **{**asked, "size": (20.0, 20.0)}).length_m == 20.0
    with pytest.raises(
        click.ClickException, match="learned by 4 keepers against 3 takers and knows nothing else"
    ):
        command.task(saved, **{**asked, "takers": 2})
    lines = command.heading("keepers[b].npz", saved, HEADER.task, 7).splitlines()
    assert "0.5 h Sarsa, 300 episodes" in lines[2]


def test_a_policy_that_is_no_file_is_named(tmp_path: Path):
    with pytest.raises(click.BadParameter, match=r"'best' is neither one of hand, random, hold nor a file"):
        command.read_policy(Path("best"))
    (tmp_path / "x").write_text("x")
    with pytest.raises(click.ClickException, match="not a policy of Keepaway"):
        command.read_policy(tmp_path / "x")


def test_training_writes_a_policy_that_can_be_watched(tmp_path: Path):
    path = tmp_path / "keepers.npz"
    result = run(
        "train", "keepaway", "--hours", "0.02", "--seed", "3", "--vision", "exact", "--save", str(path)
    )
    assert result.exit_code == 0, result.output
    assert f"arl watch keepaway --policy {path}" in result.output
    saved = command.read_policy(path)
    assert saved.header.task.exact_state
    assert saved.header.root_seed == 3
    assert saved.header.episodes >= 50
    assert saved.weights.any()
    again = tmp_path / "again.npz"
    run("train", "keepaway", "--hours", "0.02", "--seed", "3", "--vision", "exact", "--save", str(again))
    assert np.array_equal(command.read_policy(again).weights, saved.weights)


def test_training_into_nowhere_is_refused_before_it_begins(tmp_path: Path):
    result = run("train", "keepaway", "--save", str(tmp_path / "none" / "k.npz"))
    assert result.exit_code == 2
    assert "there is no folder" in result.output
