"""The board widget: what is drawn, and how little is drawn again."""

from collections.abc import Iterator
from itertools import combinations

import numpy as np
import pytest
from rich.color import Color as RichColor
from rich.color import ColorSystem
from textual.app import App, ComposeResult
from textual.color import Color
from textual.geometry import Region
from textual.strip import Strip

from arl_tui.palette import COLOUR_BLIND, HIGH_CONTRAST, PALETTES, SIXTEEN, STANDARD, Palette, palette_for
from arl_tui.widgets.board import TetrisBoard
from core.tetris.game import FallingPiece
from core.tetris.picture import UNKNOWN, Counts, Snapshot, Wall, animate, snapshot
from tests.arl_tui.widgets.refreshes import refreshes_of

L, O = 6, 1


class BoardApp(App[None]):
    """One board and nothing else."""

    def __init__(self, rows: int = 20, columns: int = 10, palette: Palette = STANDARD) -> None:
        super().__init__()
        self.board = TetrisBoard(rows, columns, palette=palette)

    def compose(self) -> ComposeResult:
        yield self.board


def falling_l(row: int) -> Snapshot:
    return snapshot(Wall(20, 10), FallingPiece(L, 2, row, 3), counts=Counts())


def background(strip: Strip, x: int) -> str:
    segments: Iterator = iter(strip.crop(x, x + 1))
    return next(segments).style.bgcolor.triplet.hex


@pytest.fixture
def paints(monkeypatch: pytest.MonkeyPatch) -> list[tuple[Region, ...]]:
    """Collect the regions of every refresh of a board."""
    return refreshes_of(TetrisBoard, monkeypatch)


async def test_a_board_of_20_rows_takes_22_lines_and_22_columns():
    app = BoardApp()
    async with app.run_test(size=(80, 24)):
        assert app.board.outer_size == (22, 22)
        assert app.screen.size == (80, 24)
        assert app.board.region.bottom <= 24


@pytest.mark.parametrize(("rows", "columns"), [(8, 4), (20, 16)])
async def test_a_board_takes_the_size_of_its_game(rows: int, columns: int):
    app = BoardApp(rows, columns)
    async with app.run_test():
        assert app.board.outer_size == (columns * 2 + 2, rows + 2)


async def test_the_piece_is_drawn_where_it_is_and_its_ghost_where_it_will_land():
    app = BoardApp()
    async with app.run_test() as pilot:
        assert app.board.show(falling_l(row=10))
        await pilot.pause()
        falling = app.board.get_component_rich_style("block--l-falling").bgcolor.triplet.hex
        # rows 10 and 11 from the bottom are lines 9 and 8 from the top; columns 3 to 5 are cells 6 to 11
        assert [background(app.board.render_line(9), x) == falling for x in (5, 6, 11, 12)] == [
            False,
            True,
            True,
            False,
        ]
        assert [background(app.board.render_line(8), x) == falling for x in (9, 10, 11, 12)] == [
            False,
            True,
            True,
            False,
        ]
        assert app.board.render_line(19).text == "      ░░░░░░        "
        assert app.board.render_line(18).text == "          ░░        "


async def test_only_the_rows_that_changed_are_painted_again(paints: list[tuple[Region, ...]]):
    app = BoardApp()
    async with app.run_test() as pilot:
        app.board.show(falling_l(row=10))
        await pilot.pause()
        paints.clear()
        app.board.show(falling_l(row=9))
        # the two rows it is in and the one it left; the ghost stays
        assert paints == [(Region(0, 8, 20, 1), Region(0, 9, 20, 1), Region(0, 10, 20, 1))]


async def test_an_equal_picture_is_not_painted_and_makes_no_new_frame(paints: list[tuple[Region, ...]]):
    app = BoardApp()
    async with app.run_test() as pilot:
        assert app.board.show(falling_l(row=10), frame=1)
        await pilot.pause()
        assert app.board.drawn_frame == 1
        paints.clear()
        assert not app.board.show(falling_l(row=10), frame=2)
        await pilot.pause()
        assert paints == []
        assert app.board.drawn_frame == 1


async def test_a_covered_board_shows_its_text_and_draws_no_frame():
    app = BoardApp()
    async with app.run_test() as pilot:
        app.board.show(falling_l(row=10), frame=1)
        await pilot.pause()
        app.board.cover("Pause\n\npress p")
        assert not app.board.show(falling_l(row=4), frame=2)
        await pilot.pause()
        lines = [app.board.render_line(y).text for y in range(20)]
        assert [line.strip() for line in lines if line.strip()] == ["Pause", "press p"]
        assert app.board.drawn_frame == 1
        app.board.uncover()
        await pilot.pause()
        assert app.board.drawn_frame == 2
        assert "░" in app.board.render_line(19).text


async def test_a_band_of_text_leaves_the_rest_of_the_board_to_be_seen():
    app = BoardApp()
    async with app.run_test() as pilot:
        app.board.cover("GAME OVER", whole=False)
        assert app.board.show(falling_l(row=1), frame=7)
        await pilot.pause()
        assert app.board.drawn_frame == 7
        assert app.board.render_line(9).text.strip() == "GAME OVER"
        assert "░" in app.board.render_line(19).text


async def test_a_snapshot_of_another_size_is_an_error():
    app = BoardApp(rows=8)
    async with app.run_test():
        with pytest.raises(ValueError, match="8 x 10 cannot show a snapshot of 20 x 10"):
            app.board.show(falling_l(row=4))


async def test_another_palette_repaints_the_board():
    app = BoardApp()
    async with app.run_test() as pilot:
        app.board.show(falling_l(row=10))
        await pilot.pause()
        before = background(app.board.render_line(9), 6)
        app.board.palette = COLOUR_BLIND
        await pilot.pause()
        assert background(app.board.render_line(9), 6) == "#e69f00" != before
        assert ">>>>>>" in app.board.render_line(9).text


async def test_filled_rows_light_up_before_they_go():
    wall = Wall(20, 10, (bytes([UNKNOWN] * 8 + [0, 0]),))
    frames = animate(wall, O, (0, 8), None, counts=Counts()).frames
    app = BoardApp()
    async with app.run_test() as pilot:
        app.board.show(frames[-2])
        await pilot.pause()
        assert {background(app.board.render_line(19), x) for x in range(20)} == {"#ffffff"}
        app.board.show(frames[-1])
        await pilot.pause()
        yellow = app.board.get_component_rich_style("block--o").bgcolor.triplet.hex
        assert [background(app.board.render_line(19), x) == yellow for x in (15, 16, 19)] == [
            False,
            True,
            True,
        ]


@pytest.mark.parametrize("palette", PALETTES.values(), ids=lambda palette: palette.name)
def test_boards_look_as_they_did(snap_compare, palette: Palette):
    wall = Wall(20, 10, (bytes([1, 2, 2, 3, 4, 5, 6, 7, 8, 0]), bytes([0, 2, 2, 3, 3, 5, 6, 0, 8, 0])))
    app = BoardApp(palette=palette)

    async def show(pilot) -> None:
        app.board.border_title = palette.title[:16]
        app.board.show(snapshot(wall, FallingPiece(L, 2, 10, 3), counts=Counts()))
        await pilot.pause()

    assert snap_compare(app, terminal_size=(24, 24), run_before=show)


# Machado, Oliveira & Fernandes 2009, severity 1.0: what a dichromat sees, in linear RGB.
SEEN_BY = {
    "protanope": (
        (0.152286, 1.052583, -0.204868),
        (0.114503, 0.786281, 0.099216),
        (-0.003882, -0.048116, 1.051998),
    ),
    "deuteranope": (
        (0.367322, 0.860646, -0.227968),
        (0.280085, 0.672501, 0.047413),
        (-0.011820, 0.042940, 0.968881),
    ),
    "tritanope": (
        (1.255528, -0.076749, -0.178779),
        (-0.078411, 0.930809, 0.147602),
        (0.004733, 0.691367, 0.303900),
    ),
}


def to_linear(srgb: np.ndarray) -> np.ndarray:
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def lightness_and_hue(colour: str, seen_by: str) -> np.ndarray:
    """Return CIE L*a*b* (D65) of a colour as somebody sees it."""
    seen = np.clip(np.array(SEEN_BY[seen_by]) @ to_linear(np.array(Color.parse(colour).rgb) / 255), 0, 1)
    to_xyz = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
    x, y, z = np.cbrt(to_xyz @ seen / np.array([0.9505, 1.0, 1.089]))
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


def closest_pair(palette: Palette, seen_by: str) -> float:
    """Return the smallest distance (Delta E 1976) between two of a palette's seven pieces."""
    seen = [lightness_and_hue(colour, seen_by) for colour in palette.colours[:7]]
    return min(float(np.linalg.norm(a - b)) for a, b in combinations(seen, 2))


@pytest.mark.parametrize("seen_by", SEEN_BY)
def test_colour_blind_people_can_tell_all_pieces_of_their_palette_apart(seen_by: str):
    # A difference of about 2.3 is just noticeable side by side; 10 is easy to see at a glance.
    assert closest_pair(COLOUR_BLIND, seen_by) > 10


@pytest.mark.parametrize("palette", [COLOUR_BLIND, HIGH_CONTRAST, SIXTEEN], ids=lambda palette: palette.name)
def test_where_colour_may_fail_every_piece_has_a_texture_of_its_own(palette: Palette):
    assert len(set(palette.textures)) == 8
    assert all(len(texture) == 2 and texture.isascii() for texture in palette.textures)


def test_sixteen_colours_stay_apart_on_a_terminal_of_sixteen_colours():
    shown = {RichColor.parse(colour).downgrade(ColorSystem.STANDARD).number for colour in SIXTEEN.colours}
    assert len(shown) == 8


def contrast(one: Color, other: Color) -> float:
    """Return the contrast ratio of WCAG 2.1, in [1, 21]."""
    darker, lighter = sorted(
        float(np.dot((0.2126, 0.7152, 0.0722), to_linear(np.array(colour.rgb) / 255)))
        for colour in (one, other)
    )
    return (lighter + 0.05) / (darker + 0.05)


@pytest.mark.parametrize("palette", PALETTES.values(), ids=lambda palette: palette.name)
def test_every_block_stands_out_from_the_empty_board(palette: Palette):
    for colour in palette.colours:
        settled = Color.parse(colour).blend(Color.parse("#000000"), palette.settled)
        # WCAG 2.1: parts of a picture that matter have a contrast of at least 3 (2.4 is the sixteen colours'
        # blue)
        assert contrast(settled, Color.parse(palette.empty)) >= (3 if palette is not SIXTEEN else 2.4)


def test_a_palette_with_a_colour_missing_is_an_error():
    with pytest.raises(ValueError, match="needs 8 colours and textures"):
        Palette(name="short", title="Short", colours=("#ffffff",), textures=("  ",))


def test_a_poorer_terminal_gets_a_palette_it_can_show():
    assert palette_for("standard", "truecolor") is STANDARD
    assert palette_for("colour-blind", "256") is COLOUR_BLIND
    assert palette_for("standard", "standard") is SIXTEEN
    assert palette_for("high-contrast", "standard") is HIGH_CONTRAST
    assert palette_for("standard", None) is HIGH_CONTRAST
    assert palette_for("standard", "truecolor", no_color=True) is HIGH_CONTRAST
    with pytest.raises(ValueError, match=r"no palette 'pink': choose one of standard, colour-blind"):
        palette_for("pink", "truecolor")
