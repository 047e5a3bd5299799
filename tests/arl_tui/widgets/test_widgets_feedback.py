"""The feedback bar, the next piece and the figures."""

from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager

import pytest
from textual.app import App, ComposeResult
from textual.containers import Horizontal, Vertical
from textual.pilot import Pilot
from textual.widget import Widget

from arl_tui.palette import COLOUR_BLIND
from arl_tui.widgets.big_letters import big
from arl_tui.widgets.board import TetrisBoard
from arl_tui.widgets.feedback_bar import FeedbackBar
from arl_tui.widgets.next_piece import NextPiece
from arl_tui.widgets.stats import Figures, StatsPanel, trend
from core.events import KeyPressed
from core.feedback.keys import KeyConfig, PressGate
from core.numerics.clock import ManualClock

SECOND = 1_000_000_000


class OneWidget(App[None]):
    """One widget in a box."""

    CSS = "Vertical { height: 22; }"

    def __init__(self, widget: Widget, width: int = 56) -> None:
        super().__init__()
        self.widget = widget
        self.width = width

    def compose(self) -> ComposeResult:
        with Vertical() as box:
            box.styles.width = self.width
            yield self.widget


def texts(widget: Widget) -> list[str]:
    return [widget.render_line(y).text for y in range(widget.size.height)]


async def until(pilot: Pilot, condition: Callable[[], bool]) -> None:
    """Wait until a timer has done its work; a busy machine may take long."""
    for _ in range(500):
        if condition():
            return
        await pilot.pause(0.01)
    pytest.fail("nothing happened for 5 seconds")


class Participant:
    """Presses keys through the real gate, one per second, and shows what comes of it."""

    def __init__(self, bar: FeedbackBar) -> None:
        self.gate = PressGate(bar.keys)
        self.gate.episode_started()
        self.bar = bar
        self.now_ns = 0

    def press(self, key: str, after_ns: int = SECOND) -> None:
        self.now_ns += after_ns
        for record in self.gate.judge(key, self.now_ns):
            if isinstance(record, KeyPressed):
                self.bar.show_press(record, self.gate.presses_left)
            else:
                self.bar.show_retraction(record, self.gate.presses_left)


@asynccontextmanager
async def participant_at(keys: KeyConfig | None = None, *, width: int = 56) -> AsyncIterator[Participant]:
    """Seat a participant before a bar whose words stay."""
    bar = FeedbackBar(keys or KeyConfig(), hold_s=0)
    async with OneWidget(bar, width).run_test():
        yield Participant(bar)


async def test_each_press_is_answered_at_once_with_its_word():
    async with participant_at() as participant:
        bar = participant.bar
        for key, word in (("j", "GOOD"), ("f", "BAD"), ("u", "TAKEN BACK"), ("j", "GOOD")):
            participant.press(key)
            assert bar.word == word
            assert [line.strip() for line in texts(bar)[:3]] == [line.strip() for line in big(word)]


async def test_good_and_bad_differ_in_more_than_colour():
    good, bad = big("GOOD"), big("BAD")
    assert good != bad
    assert len({len(line) for line in good}) == len({len(line) for line in bad}) == 1


async def test_presses_left_are_counted_down_and_given_back():
    async with participant_at() as participant:
        bar = participant.bar
        assert texts(bar)[5].strip() == "● ● ● ● ●  5 of 5 presses left"
        participant.press("j")
        participant.press("f")
        assert texts(bar)[5].strip() == "● ● ● ○ ○  3 of 5 presses left"
        participant.press("u")
        assert texts(bar)[5].strip() == "● ● ● ● ○  4 of 5 presses left"
        bar.begin_game(5)
        assert texts(bar)[5].strip() == "● ● ● ● ●  5 of 5 presses left"
        assert bar.word == ""


async def test_a_press_too_many_says_why_it_does_not_count():
    async with participant_at(KeyConfig(max_presses_per_episode=1)) as participant:
        bar = participant.bar
        participant.press("j")
        participant.press("j")
        assert bar.word == ""
        assert texts(bar)[3].strip() == "No presses left in this game: not counted"
        assert texts(bar)[1].strip() == "watch: no presses left in this game"


async def test_a_held_key_is_explained_and_its_repeats_change_nothing():
    async with participant_at() as participant:
        bar = participant.bar
        participant.press("j")
        for gap_ms in (500, 30, 30, 30):
            participant.press("j", gap_ms * 1_000_000)
        assert bar.word == "GOOD"
        assert texts(bar)[3].strip() == "A key that is held down counts once"
        assert bar.presses_left == 4


async def test_the_take_back_key_is_not_called_meaningless():
    async with participant_at() as participant:
        bar = participant.bar
        participant.press("u")
        assert bar.note == ""
        participant.press("x")
        assert bar.note == "This key has no meaning here"


async def test_the_request_for_a_wrong_press_is_seen_until_it_is_withdrawn():
    bar = FeedbackBar(KeyConfig(), hold_s=0)
    app = OneWidget(bar)
    async with app.run_test():
        assert not any("WRONG" in line for line in texts(bar))
        bar.ask_wrong(True)
        assert any("press the WRONG key" in line for line in texts(bar))
        bar.ask_wrong(False)
        assert not any("WRONG" in line for line in texts(bar))


async def test_the_bar_shows_the_keys_of_this_session():
    bar = FeedbackBar(KeyConfig(good="g", bad="b", retract="z"), hold_s=0)
    app = OneWidget(bar)
    async with app.run_test():
        assert texts(bar)[-1].split() == ["g", "good", "b", "bad", "z", "take", "back"]


async def test_the_word_fades_but_the_presses_left_stay():
    bar = FeedbackBar(KeyConfig(), hold_s=0.01)
    app = OneWidget(bar)
    async with app.run_test() as pilot:
        Participant(bar).press("j")
        assert bar.word == "GOOD"
        await until(pilot, lambda: bar.word == "")
        assert bar.presses_left == 4


async def test_nothing_moves_whatever_is_said():
    bar = FeedbackBar(KeyConfig(), hold_s=0)
    app = OneWidget(bar)
    async with app.run_test() as pilot:
        region = bar.region
        participant = Participant(bar)
        for key in "jfuxjjjjj":
            participant.press(key)
            bar.ask_wrong(key == "f")
            await pilot.pause()
            assert bar.region == region
            assert {len(line) for line in texts(bar)} == {bar.size.width}


async def test_where_there_is_little_room_words_are_small_and_presses_are_counted_in_figures():
    async with participant_at(KeyConfig(max_presses_per_episode=20), width=44) as participant:
        bar = participant.bar
        participant.press("j")
        assert texts(bar)[0].strip() == big("GOOD")[0].strip()
        participant.press("u")
        assert [line.strip() for line in texts(bar)[:3]] == ["", "TAKEN BACK", ""]
        assert texts(bar)[5].strip() == "20 of 20 presses left"


@pytest.mark.parametrize("width", [36, 30])
async def test_beside_a_pitch_nothing_that_is_said_is_cut_off(width: int):
    async with participant_at(KeyConfig(max_presses_per_episode=1), width=width) as participant:
        bar = participant.bar
        assert texts(bar)[-1].split() == ["j", "good", "f", "bad", "u", "take", "back"]
        bar.ask_wrong(True)
        assert "press the WRONG key" in texts(bar)[7]
        participant.press("j")
        participant.press("j")
        assert texts(bar)[1].strip().startswith("watch: no presses left")
        assert " ".join(" ".join(texts(bar)[3:5]).split()) == "No presses left in this game: not counted"
        assert {len(line) for line in texts(bar)} == {width - 2}


async def test_a_simulated_press_is_called_one():
    bar = FeedbackBar(KeyConfig(), hold_s=0)
    app = OneWidget(bar)
    async with app.run_test():
        gate = PressGate(KeyConfig())
        gate.episode_started()
        for record in gate.judge("f", SECOND, source="simulated"):
            assert isinstance(record, KeyPressed)
            bar.show_press(record, gate.presses_left)
        assert bar.note == "Counted by the simulated participant"


@pytest.mark.parametrize(
    ("piece", "upper", "lower"),
    [
        (0, "", "████████"),
        (1, "████", "████"),
        (2, "██", "██████"),
        (5, "██", "██████"),
    ],
)
async def test_the_next_piece_lies_flat_in_the_middle(piece: int, upper: str, lower: str):
    box = NextPiece()
    app = OneWidget(box)
    async with app.run_test():
        box.show(piece)
        empty = box.get_component_rich_style("block--empty").bgcolor
        drawn = [
            "".join(
                "█" if segment.style is not None and segment.style.bgcolor not in (empty, None) else " "
                for segment in box.render_line(y)
                for _ in segment.text
            )
            for y in range(2)
        ]
        assert [line.strip() for line in drawn] == [upper, lower]
        assert {len(line) for line in drawn} == {10}


async def test_no_next_piece_is_an_empty_box():
    box = NextPiece()
    app = OneWidget(box)
    async with app.run_test():
        box.show(3)
        box.show(-1)
        assert texts(box) == [" " * 10] * 2


async def test_figures_are_shown_at_once_and_then_at_most_four_times_a_second():
    clock = ManualClock()
    panel = StatsPanel(clock=clock)
    app = OneWidget(panel)
    async with app.run_test():
        panel.show(Figures(lines=1, pieces=2))
        assert panel.figures.lines == 1
        clock.advance_ns(100_000_000)
        panel.show(Figures(lines=2, pieces=3))
        panel.show(Figures(lines=3, pieces=4))
        assert panel.figures.lines == 1
        clock.advance_ns(200_000_000)
        panel._draw()
        assert panel.figures.lines == 3
        clock.advance_ns(SECOND // 4)
        panel.show(Figures(lines=4, pieces=5))
        assert panel.figures.lines == 4


async def test_waiting_figures_are_drawn_without_being_asked_again():
    panel = StatsPanel()
    app = OneWidget(panel)
    async with app.run_test() as pilot:
        panel.show(Figures(lines=1))
        panel.show(Figures(lines=2))
        assert panel.figures.lines == 1
        await until(pilot, lambda: panel.figures.lines == 2)
        assert texts(panel)[0].split() == ["Lines", "2"]


async def test_figures_say_which_game_it_is_and_what_the_feedback_weighs():
    panel = StatsPanel()
    app = OneWidget(panel)
    async with app.run_test():
        panel.show(Figures(lines=12, pieces=40, episode=2, episodes=6, human_weights=(0.0, 0.5, 1.0)))
        assert [line.split() for line in texts(panel)] == [
            ["Game", "2", "of", "6"],
            ["Lines", "12"],
            ["Pieces", "40"],
            ["Influence", "1.00", "▁▅█"],
        ]


def test_a_trend_keeps_the_newest_values_and_cuts_what_lies_outside():
    # 8 bars: 0 -> the first, 1 -> the last; 0.5 -> round(3.5) = 4 (to even), the fifth
    assert trend((0.0, 0.5, 1.0), 10) == "▁▅█"
    assert trend((0.0, 0.5, 1.0), 2) == "▅█"
    assert trend((-3.0, 7.0), 5) == "▁█"
    assert trend((), 5) == trend((0.5,), 0) == ""


@pytest.mark.parametrize("size", [(80, 24), (120, 40)])
def test_a_live_screen_made_of_these_widgets_looks_as_it_did(snap_compare, size: tuple[int, int]):
    bar = FeedbackBar(KeyConfig(), hold_s=0)
    panel = StatsPanel()
    following = NextPiece(palette=COLOUR_BLIND)

    class Everything(App[None]):
        CSS = """
        Screen { align: center middle; }
        #all { width: 80; height: 22; }
        #side { margin-left: 1; }
        #top { height: 6; }
        StatsPanel { margin-left: 1; }
        FeedbackBar { margin-top: 3; }
        """

        def compose(self) -> ComposeResult:
            with Horizontal(id="all"):
                yield TetrisBoard(palette=COLOUR_BLIND)
                with Vertical(id="side"):
                    with Horizontal(id="top"):
                        yield following
                        yield panel
                    yield bar

    async def scene(pilot) -> None:
        participant = Participant(bar)
        participant.press("j")
        participant.press("f")
        bar.ask_wrong(True)
        following.show(4)
        panel.show(Figures(lines=12, pieces=40, episode=2, episodes=6, human_weights=(0.0, 0.25, 0.5, 0.75)))
        await pilot.pause()

    assert snap_compare(Everything(), terminal_size=size, run_before=scene)
