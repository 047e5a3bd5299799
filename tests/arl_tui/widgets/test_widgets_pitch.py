"""The pitch: what is drawn in each rendering, and how little is drawn again."""

import math
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from itertools import combinations

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from textual.app import App, ComposeResult
from textual.containers import Horizontal
from textual.geometry import Region
from textual.pilot import Pilot
from textual.widgets import Static

from arl_tui.palette import COLOUR_BLIND, HIGH_CONTRAST, PALETTES, SIXTEEN, STANDARD, Palette
from arl_tui.widgets.pitch import PitchWidget, detail_for
from arl_tui.widgets.pitch_colours import COLOURS
from arl_tui.widgets.pitch_drawing import draw, fit, plain
from arl_tui.widgets.pitch_ink import BALL, DETAILS, INKS, KEEPER, PATH, Detail, Row, Shape
from core.keepaway.picture import PitchFrame, PlayerView
from tests.arl_tui.pitches import HOLDING, PASSING
from tests.arl_tui.widgets.refreshes import refreshes_of
from tests.arl_tui.widgets.test_widgets_board import SEEN_BY, contrast, lightness_and_hue

SMALL = Shape(42, 22)


def inks(rows: tuple[Row, ...]) -> list[list[int]]:
    """Return the ink of every cell, line by line."""
    return [[ink for text, ink, _ in row for _ in text] for row in rows]


def cells_of(rows: tuple[Row, ...], ink: int) -> list[tuple[int, int]]:
    """Return (line, column) of every cell with an ink."""
    return [(y, x) for y, line in enumerate(inks(rows)) for x, found in enumerate(line) if found == ink]


def where(lines: list[str], name: str) -> tuple[int, int]:
    """Return line and column of a name that is there once."""
    (found,) = [(y, line.index(name)) for y, line in enumerate(lines[1:-1], 1) if name in line]
    return found


# --- the drawing --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("detail", DETAILS)
def test_players_are_drawn_where_they_are(detail: Detail):
    lines = plain(draw(PASSING, SMALL, detail))
    # 2 columns and 1 line per metre; K1 is 4 m from the left and 5 m from the top, behind the boundary.
    assert where(lines, "K1") == (6, 8)
    assert where(lines, "K2") == (4, 36)
    assert where(lines, "K3") == (19, 34)
    assert where(lines, "T1") == (11, 12)
    assert where(lines, "T2") == (15, 20)


def test_plain_ascii_is_plain_ascii():
    for frame in (PASSING, HOLDING):
        assert all(line.isascii() for line in plain(draw(frame, SMALL, "ascii", "2 presses left")))


@pytest.mark.parametrize("detail", DETAILS)
def test_the_boundary_says_episode_time_option_and_note(detail: Detail):
    lines = plain(draw(PASSING, SMALL, detail, "2 presses left"))
    assert "Episode 3" in lines[0]
    assert "7.0 s" in lines[0]
    assert "K1 passes to K2" in lines[-1]
    assert "2 presses left" in lines[-1]


@pytest.mark.parametrize("detail", DETAILS)
@pytest.mark.parametrize("window", [(80, 24), (60, 24)])
def test_presses_left_and_time_are_there_in_any_window_and_words_are_shortened_for_them(
    detail: Detail, window: tuple[int, int]
):
    columns, lines = window
    shape = fit(20.0, 20.0, columns - 36, lines)
    assert shape is not None
    drawn = plain(draw(PASSING, shape, detail, "2 presses left", "A rather long title of the game"))
    assert "7.0 s" in drawn[0]
    assert "2 presses left" in drawn[-1]
    if columns == 80:
        assert "A rather long title of the game" in drawn[0]
        assert "K1 passes to K2" in drawn[-1]
    else:
        assert (" A rather l… " if detail == "braille" else " A rather... ") in drawn[0]
        assert "K1" not in drawn[-1]
    assert {len(line) for line in drawn} == {shape.columns}


@pytest.mark.parametrize(
    ("columns", "words"),
    [(40, "K1 passes to K2"), (37, "K1 passes to K2"), (36, "K1 passes t..."), (30, "K1 pa..."), (28, "--")],
)
def test_words_are_shortened_no_more_than_they_must(columns: int, words: str):
    line = plain(draw(PASSING, Shape(columns, 12), "ascii", "2 presses left"))[-1]
    assert words in line
    assert line.endswith(" 2 presses left -+")


@pytest.mark.parametrize(
    ("angle", "mark", "step"),
    [
        (0, ">", (0, 2)),
        (45, "\\", (1, 2)),
        (90, "v", (1, 0)),
        (135, "/", (1, -1)),
        (180, "<", (0, -1)),
        (-135, "\\", (-1, -1)),
        (-90, "^", (-1, 0)),
        (-45, "/", (-1, 2)),
    ],
)
def test_letters_show_which_way_a_player_faces(angle: float, mark: str, step: tuple[int, int]):
    players = (PlayerView(0.0, 0.0, angle), *PASSING.players[1:])
    frame = msgspec.structs.replace(PASSING, players=players, trail=(), target=-1, ball=(-9.0, 9.0))
    lines = plain(draw(frame, SMALL, "ascii"))
    line, column = where(lines, "K1")
    down, right = step
    row = lines[line + down]
    marks = {row[column + right], row[column + right + 1]} if right == 0 else {row[column + right]}
    assert mark in marks


@pytest.mark.parametrize("detail", ["half", "braille"])
def test_dots_show_which_way_a_player_faces(detail: Detail):
    for angle in range(-170, 181, 10):
        players = (PlayerView(0.2, 0.3, angle), *[PlayerView(9.0, 9.0, 0.0)] * 4)
        frame = msgspec.structs.replace(PASSING, players=players, trail=(), target=-1, ball=(-9.0, 9.0))
        dots = [(y, x) for y, x in cells_of(draw(frame, SMALL, detail), KEEPER) if y < 15]
        # Its name is centred on column 21, line 11.5.
        down = sum(y + 0.5 for y, _ in dots) / len(dots) - 11.5
        right = (sum(x + 0.5 for _, x in dots) / len(dots) - 21) / 2
        turned = math.degrees(math.atan2(down, right)) - angle
        assert abs((turned + 180) % 360 - 180) < 40


@pytest.mark.parametrize("detail", DETAILS)
def test_the_pass_is_dotted_from_the_ball_to_its_receiver(detail: Detail):
    dots = cells_of(draw(PASSING, SMALL, detail), PATH)
    assert len(dots) >= 5
    # From (-2, -5.4) to (8, -7): between their columns and lines, and the line falls with the column.
    assert all(16 <= x <= 37 and 3 <= y <= 6 for y, x in dots)
    assert sorted(dots, key=lambda d: d[1]) == sorted(dots, key=lambda d: (-d[0], d[1]))
    assert not cells_of(draw(HOLDING, SMALL, detail), PATH)


def test_the_player_with_the_ball_is_marked_without_colour():
    # The ball lies where the second bracket would be.
    assert "[K1o" in plain(draw(HOLDING, SMALL, "ascii"))[6]
    assert "[" not in "".join(plain(draw(PASSING, SMALL, "ascii"))[1:-1])


@pytest.mark.parametrize("detail", DETAILS)
def test_the_ball_moves_in_steps_as_fine_as_the_rendering(detail: Detail):
    frames = [msgspec.structs.replace(HOLDING, ball=(x / 40, 0.0)) for x in range(200)]
    pictures = {draw(frame, SMALL, detail) for frame in frames}
    # 5 m are 10 columns; braille draws the ball in half columns.
    assert len(pictures) == pytest.approx(20 if detail == "braille" else 10, abs=1)


def views() -> st.SearchStrategy[PlayerView]:
    place = st.floats(-12, 12)
    return st.builds(PlayerView, place, place, st.floats(-180, 180))


@st.composite
def frames(draw_from: st.DrawFn) -> PitchFrame:
    keepers = draw_from(st.integers(2, 5))
    takers = draw_from(st.integers(1, 4))
    players = draw_from(st.lists(views(), min_size=keepers + takers, max_size=keepers + takers))
    if draw_from(st.booleans()):  # a crowd
        players = [PlayerView(players[0].x_m, players[0].y_m, p.body_deg) for p in players]
    place = st.tuples(st.floats(-14, 14), st.floats(-14, 14))
    target = draw_from(st.integers(-1, keepers - 1))
    return PitchFrame(
        length_m=draw_from(st.sampled_from([10.0, 20.0, 30.0])),
        width_m=draw_from(st.sampled_from([10.0, 20.0])),
        n_keepers=keepers,
        players=tuple(players),
        ball=draw_from(place),
        trail=tuple(draw_from(st.lists(place, max_size=5))),
        holder=draw_from(st.integers(-1, len(players) - 1)),
        decider=0 if target >= 0 else -1,
        target=target,
    )


@settings(max_examples=150)
@given(frames(), st.integers(60, 160), st.integers(14, 60), st.sampled_from(DETAILS))
def test_every_name_and_the_ball_can_be_seen_and_nothing_lies_outside(
    frame: PitchFrame, columns: int, lines: int, detail: Detail
):
    shape = fit(frame.length_m, frame.width_m, columns, lines)
    if shape is None:
        return
    rows = draw(frame, shape, detail)
    drawn = plain(rows)
    assert len(drawn) == shape.lines
    assert {len(line) for line in drawn} == {shape.columns}
    names = "\n".join(
        "".join(letter if "name" in INKS[ink] else " " for letter, ink in zip(line, row, strict=True))
        for line, row in zip(drawn, inks(rows), strict=True)
    )
    for player in range(len(frame.players)):
        assert names.count(frame.name(player)) == 1
    assert len(cells_of(rows, BALL)) in (1, 2)


@settings(max_examples=50)
@given(st.floats(10, 40), st.floats(10, 40), st.integers(20, 250), st.integers(10, 80))
def test_a_region_is_drawn_at_its_true_proportions_as_large_as_fits(
    length_m: float, width_m: float, columns: int, lines: int
):
    shape = fit(length_m, width_m, columns, lines)
    if shape is None:
        assert min((lines - 2) / width_m, (columns - 2) / 2 / length_m) * min(length_m, width_m) < 11
        return
    assert shape.columns <= columns
    assert shape.lines <= lines
    per_metre_across, per_metre_down = (shape.columns - 2) / length_m, (shape.lines - 2) / width_m
    # True up to a character: a cell is twice as high as wide.
    assert abs(per_metre_across / 2 - per_metre_down) <= 1 / min(length_m, width_m)
    assert shape.lines + 1 > lines or shape.columns + 3 > columns


def test_the_papers_pitch_fits_a_small_terminal_beside_a_panel():
    assert fit(20.0, 20.0, 80, 24) == Shape(46, 24)
    assert fit(20.0, 20.0, 42, 22) == SMALL
    assert fit(20.0, 20.0, 20, 24) is None


# --- colours ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seen_by", SEEN_BY)
def test_colour_blind_people_can_tell_keepers_takers_and_ball_apart(seen_by: str):
    seen = [lightness_and_hue(COLOURS["standard"][ink], seen_by) for ink in ("keeper", "taker", "ball")]
    assert min(math.dist(a, b) for a, b in combinations(seen, 2)) > 20


@pytest.mark.parametrize("palette", PALETTES.values(), ids=lambda palette: palette.name)
def test_names_and_ball_stand_out(palette: Palette):
    from textual.color import Color

    colours = {ink: Color.parse(colour) for ink, colour in COLOURS[palette.name].items()}
    assert contrast(colours["keeper-name"], colours["keeper"]) > 4.5
    assert contrast(colours["taker-name"], colours["taker"]) > 4.5
    assert contrast(colours["holder-name"], colours["words"]) > 4.5
    for ink in ("ball", "words", "trail", "path"):
        assert contrast(colours[ink], colours["stripe"]) > 4.5


# --- the widget ---------------------------------------------------------------------------------------------


class PitchApp(App[None]):
    """A pitch and a panel."""

    def __init__(self, detail: Detail = "ascii", palette: Palette = STANDARD) -> None:
        super().__init__()
        self.pitch = PitchWidget(detail=detail, beside=34, palette=palette)

    def compose(self) -> ComposeResult:
        with Horizontal():
            yield self.pitch
            yield Static("panel", id="panel")


@pytest.fixture
def paints(monkeypatch: pytest.MonkeyPatch) -> list[tuple[Region, ...]]:
    """Collect the regions of every refresh of a pitch."""
    return refreshes_of(PitchWidget, monkeypatch)


@asynccontextmanager
async def pitch_on_screen() -> AsyncIterator[tuple[PitchWidget, Pilot[None]]]:
    """Show K1 with the ball, as frame 1."""
    app = PitchApp()
    async with app.run_test(size=(80, 24)) as pilot:
        app.pitch.show(HOLDING, 1)
        await pilot.pause()
        yield app.pitch, pilot


async def test_the_pitch_is_as_wide_as_it_is_drawn():
    app = PitchApp()
    async with app.run_test(size=(80, 24)):
        assert app.pitch.size == (46, 24)
        assert app.query_one("#panel").region.x == 46


async def test_only_the_lines_that_changed_are_painted_again(paints: list[tuple[Region, ...]]):
    async with pitch_on_screen() as (pitch, _pilot):
        assert pitch.drawn_frame == 1
        paints.clear()
        moved = (*HOLDING.players[:2], PlayerView(7.4, 8.0, -100.0), *HOLDING.players[3:])
        assert pitch.show(msgspec.structs.replace(HOLDING, players=moved), 2)
        ((above, line),) = paints
        assert (above.height, line.height, above.width) == (1, 1, 46)
        assert line.y == above.y + 1


async def test_an_equal_picture_is_not_painted_and_makes_no_new_frame(paints: list[tuple[Region, ...]]):
    async with pitch_on_screen() as (pitch, pilot):
        paints.clear()
        assert not pitch.show(HOLDING, 2)
        await pilot.pause()
        assert paints == []
        assert pitch.drawn_frame == 1


async def test_a_covered_pitch_shows_its_text_and_draws_no_frame():
    async with pitch_on_screen() as (pitch, pilot):
        pitch.cover("Pause\n\npress p")
        assert not pitch.show(PASSING, 2)
        await pilot.pause()
        lines = [pitch.render_line(y).text for y in range(24)]
        assert [line.strip() for line in lines if line.strip()] == ["Pause", "press p"]
        assert pitch.drawn_frame == 1
        pitch.uncover()
        await pilot.pause()
        assert pitch.drawn_frame == 2


async def test_a_larger_window_has_a_larger_pitch_with_everything_on_it():
    app = PitchApp("braille")
    async with app.run_test(size=(80, 24)) as pilot:
        app.pitch.show(PASSING, 1)
        await pilot.resize_terminal(150, 50)
        await pilot.pause()
        assert app.pitch.size == (98, 50)
        text = "\n".join(app.pitch.render_line(y).text for y in range(50))
        assert all(name in text for name in ("K1", "K2", "K3", "T1", "T2"))


async def test_a_window_that_is_too_small_says_so():
    app = PitchApp()
    async with app.run_test(size=(50, 24)) as pilot:
        app.pitch.show(PASSING, 1)
        await pilot.pause()
        assert "Too small" in "".join(app.pitch.render_line(y).text for y in range(24))
        assert app.pitch.drawn_frame == -1


async def test_another_detail_draws_the_same_picture_otherwise():
    app = PitchApp("ascii")
    async with app.run_test(size=(80, 24)) as pilot:
        app.pitch.show(PASSING, 1)
        await pilot.pause()
        app.pitch.detail = "half"
        await pilot.pause()
        assert "┌" in app.pitch.render_line(0).text


async def test_a_picture_of_another_region_is_an_error():
    app = PitchApp()
    async with app.run_test(size=(80, 24)):
        with pytest.raises(ValueError, match="20 m x 20 m cannot show a picture of 30 m x 20 m"):
            app.pitch.show(msgspec.structs.replace(PASSING, length_m=30.0))


@pytest.mark.parametrize(
    ("detail", "palette"),
    [
        ("ascii", STANDARD),
        ("half", STANDARD),
        ("braille", COLOUR_BLIND),
        ("ascii", HIGH_CONTRAST),
        ("half", SIXTEEN),
    ],
)
def test_pitches_look_as_they_did(snap_compare, detail: Detail, palette: Palette):
    app = PitchApp(detail, palette)

    async def show(pilot) -> None:
        app.pitch.note = "2 presses left"
        app.pitch.show(PASSING if detail != "braille" else HOLDING)
        await pilot.pause()

    assert snap_compare(app, terminal_size=(80, 24), run_before=show)


def test_terminals_get_the_finest_rendering_they_can_show():
    assert detail_for({"TERM": "xterm-256color"}, "utf-8") == "braille"
    assert detail_for({"TERM": "linux"}, "UTF-8") == "half"
    assert detail_for({"TERM": "vt100"}, "utf-8") == "ascii"
    assert detail_for({"TERM": "xterm"}, "iso8859-1") == "ascii"
    assert detail_for({"TERM": "xterm"}, "ANSI_X3.4-1968") == "ascii"
