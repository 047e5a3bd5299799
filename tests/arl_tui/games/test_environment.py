"""A Gymnasium environment on screen: its pictures as data, and in half blocks."""

from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
from click.testing import CliRunner
from textual.app import App, ComposeResult

from arl_tui.app.link import Picture, TakenFor, _from_worker
from arl_tui.cli import main
from arl_tui.games.gymnasium.panel import GymnasiumPanel
from arl_tui.games.panel import Progress
from arl_tui.games.registry import screens_of, try_out
from arl_tui.language import tr, use
from arl_tui.palette import palette_for
from arl_tui.worker import start_worker
from core.interop.gymnasium.config import GymnasiumConfig
from core.interop.gymnasium.picture import NO_ACTION, EnvPicture, smaller
from core.plugins import GameError
from core.session.protocol import DEFAULTS, Protocol, SessionConfig
from tests.arl_tui.fakes import episode_started, step_taken
from tests.core.interop import own_task
from tests.core.sessions import simulated

gymnasium = pytest.importorskip("gymnasium")
pytest.importorskip("pygame")

OWN = "tests.core.interop.own_task"


def test_pictures_are_small_travel_as_data_and_follow_the_actions() -> None:
    renderer = screens_of(DEFAULTS["gymnasium:MountainCar-v0"]).renderer(DEFAULTS["gymnasium:MountainCar-v0"])
    (first,) = renderer.begin(episode_started(0))
    step = msgspec.structs.replace(step_taken(0), detail={"action": 2, "time": 0}, reward=-1.0)
    for _ in range(30):
        (tick,) = renderer.act(step)
    assert len(tick.view.pixels) == 3 * tick.view.width * tick.view.height
    assert (tick.view.width, tick.view.steps, tick.view.reward) == (126, 30, -30.0)
    assert tick.view.pixels != first.view.pixels
    assert (first.view.action, tick.view.action) == (NO_ACTION, 2)
    sent = msgspec.msgpack.encode(Picture(number=1, step=0, view=tick.view))
    assert _from_worker.decode(sent).view == tick.view


def test_a_picture_is_made_smaller_by_means_of_blocks() -> None:
    picture = np.zeros((80, 84, 3), np.uint8)
    picture[:, ::2] = 200
    small = smaller(picture, 42, 40)
    assert small.shape == (40, 42, 3)
    assert (small == 100).all()


def about(env: str = "MountainCar-v0", **domain: Any) -> Protocol:
    return msgspec.structs.replace(DEFAULTS["gymnasium"], domain=GymnasiumConfig(env, **domain))


class Beside(App[None]):
    """The picture and the figures, as the play screen has them."""

    def __init__(self, panel: GymnasiumPanel) -> None:
        super().__init__()
        self.panel = panel

    def compose(self) -> ComposeResult:
        yield self.panel.game_widget()
        yield from self.panel.figures()

    def text(self) -> str:
        return "\n".join(strip.text for strip in self.screen._compositor.render_strips())


def panel_of(protocol: Protocol) -> GymnasiumPanel:
    panel = screens_of(protocol).panel(protocol, palette_for("standard", "truecolor"))
    assert isinstance(panel, GymnasiumPanel)
    return panel


async def test_the_screen_says_what_was_done_and_what_a_press_was_taken_for() -> None:
    app = Beside(panel_of(about()))
    async with app.run_test(size=(80, 40)) as pilot:
        for step, action in enumerate((0, 2)):
            view = EnvPicture(text="a car", action=action, steps=step + 1, reward=-1.0 - step)
            app.panel.show(Picture(number=step, step=step, view=view), Progress(1, 2, ()))
        await pilot.pause()
        text = app.text()
        assert "drive to the right" in text
        # The figures stand beside the picture: they are not said twice.
        assert "reward" not in text
        marks = [app.panel.mark(TakenFor(press=0, value=1.0, step=step)) for step in (0, 1, -1, 70)]
        assert marks == [
            "for: drive to the left",
            "for: drive to the right",
            "but no step was on screen",
            "for the last step",
        ]


async def test_text_stands_in_the_middle_with_its_colours_and_moves_no_cursor() -> None:
    app = Beside(panel_of(about()))
    async with app.run_test(size=(80, 40)) as pilot:
        view = EnvPicture(text="\x1b[41mS\x1b[0mFF\x1b[2J\x07\nFHF", action=1)
        app.panel.show(Picture(number=0, step=0, view=view), Progress(1, 2, ()))
        await pilot.pause()
        inside = app.panel.widget.size
        lines = [app.panel.widget.render_line(y) for y in range(inside.height)]
        assert [line.text.strip() for line in lines if line.text.strip()] == ["SFF", "FHF"]
        assert lines[inside.height // 2].text == "FHF".center(inside.width)
        first = next(segment for line in lines for segment in line if segment.text == "S")
        assert first.style is not None
        assert first.style.bgcolor is not None
        assert first.style.bgcolor.number == 1


async def test_a_picture_is_as_large_as_there_is_room() -> None:
    app = Beside(panel_of(about()))
    async with app.run_test(size=(160, 50)) as pilot:
        pixels = np.full((84, 126, 3), 7, np.uint8).tobytes()
        app.panel.show(
            Picture(number=0, step=0, view=EnvPicture(width=126, height=84, pixels=pixels)),
            Progress(1, 2, ()),
        )
        widths = []
        for columns, lines in ((44, 23), (124, 49)):
            app.panel.widget.styles.width, app.panel.widget.styles.height = columns, lines
            await pilot.pause()
            drawn = [app.panel.widget.render_line(y).text for y in range(app.panel.widget.size.height)]
            widths.append((max(line.count("▀") for line in drawn), sum("▀" in line for line in drawn)))
        # 42 x 28 pixels, and 122 x 81 (the last row is drawn twice).
        assert widths == [(42, 14), (122, 41)]


def test_participants_are_told_the_task_and_the_actions() -> None:
    known, own = about(), about("lamp:make", task="walk to the [lamp] {x}", actions=("go left", "go right"))
    screens = screens_of(known)

    def welcome(protocol: Protocol) -> str:
        words = screens.words_for(protocol)
        return tr(words.welcome, games="2 games", practises="", task=words.task)

    assert "try a task, 2 games: get the car up to the flag." in welcome(known)
    assert "walk to the \\[lamp] {x}." in welcome(own)
    assert "try a task, 2 games. It does not know" in welcome(about("lamp:make"))
    assert [screens.option({"action": n}, own) for n in (0, 1, 2)] == ["go left", "go right", "action 2"]
    assert screens.option({"action": 3}, about("FrozenLake8x8-v1")) == "go up"
    use("de")
    try:
        assert "das Auto hinauf zur Fahne bringen" in welcome(known)
        assert screens.option({"action": 2}, known) == "nach rechts fahren"
    finally:
        use("en")


@pytest.mark.parametrize(
    ("env", "told"),
    [
        ("Pendulum-v1", "only discrete ones can be learned"),
        (f"{__name__}:Unseen", 'with render_mode="ansi": render.. gave nothing: text, or pixels'),
        (f"{__name__}:Flat", r"render.. gave ndarray of shape .3, 4.: text, or pixels.*can be simulated"),
    ],
)
def test_what_cannot_be_shown_is_refused_before_a_session(env: str, told: str) -> None:
    with pytest.raises(GameError, match=told):
        try_out(about(env))


class Unseen(gymnasium.Env):
    observation_space = gymnasium.spaces.Discrete(2)
    action_space = gymnasium.spaces.Discrete(2)

    def __init__(self, render_mode: str | None = None) -> None:
        self.render_mode = render_mode

    def reset(self, *, seed: Any = None, options: Any = None) -> Any:
        return 0, {}

    def step(self, action: int) -> Any:
        return 0, 0.0, False, False, {}

    def render(self) -> Any:
        return None


class Flat(Unseen):
    def render(self) -> Any:
        return np.zeros((3, 4))


def test_the_worker_says_why_before_anything_else_and_without_a_traceback() -> None:
    link = start_worker(about("Pendulum-v1"), 1)
    try:
        refusal = link.refusal()
        assert refusal.startswith("Pendulum-v1 has the actions Box")
        assert "Traceback" not in refusal
    finally:
        link.close()


def test_a_protocol_whose_environment_cannot_be_played_is_not_called_usable(tmp_path: Path) -> None:
    path = tmp_path / "pendulum.toml"
    path.write_text('[domain]\ntype = "gymnasium"\nenv = "MountainCra-v0"\n')
    result = CliRunner().invoke(main, ["protocol", "--check", str(path)])
    assert result.exit_code == 1
    assert "has no environment 'MountainCra-v0': the nearest is MountainCar-v0" in result.output
    assert "can be used" not in result.output


def test_a_recording_whose_environment_is_gone_is_answered_with_a_message(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    protocol = msgspec.structs.replace(
        about(f"{OWN}:make", phi=f"{OWN}:phi"),
        session=SessionConfig(episodes=1, unseen_between=0, watched_steps=3, unseen_steps=3),
    )
    simulated(tmp_path, protocol)
    monkeypatch.delattr(own_task, "make")
    result = CliRunner().invoke(main, ["replay", str(tmp_path / "session-5.jsonl")])
    assert result.exit_code == 1
    assert "Error: there is no function 'tests.core.interop.own_task:make'" in result.output
    assert isinstance(result.exception, SystemExit)
