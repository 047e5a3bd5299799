"""The board widget: what is drawn, and how little is drawn again."""

from collections.abc import Iterator

import pytest
from textual.app import App, ComposeResult
from textual.geometry import Region
from textual.strip import Strip

from arl_tui.palette import COLOUR_BLIND, HIGH_CONTRAST, PALETTES, SIXTEEN, STANDARD, Palette, palette_for
from arl_tui.widgets.board import TetrisBoard
from core.tetris.game import FallingPiece
from core.tetris.picture import Counts, Snapshot, Wall, animate, snapshot

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
    asked: list[tuple[Region, ...]] = []
    refresh = TetrisBoard.refresh

    def noting(self: TetrisBoard, *regions: Region, **options: bool) -> TetrisBoard:
        asked.append(regions)
        return refresh(self, *regions, **options)

    monkeypatch.setattr(TetrisBoard, "refresh", noting)
    return asked


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
    wall = Wall.of_board((1, 1, 1, 1, 1, 1, 1, 1, 0, 0), 20)
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


def test_a_poorer_terminal_gets_a_palette_it_can_show():
    assert palette_for("standard", "truecolor") is STANDARD
    assert palette_for("colour-blind", "256") is COLOUR_BLIND
    assert palette_for("standard", "standard") is SIXTEEN
    assert palette_for("high-contrast", "standard") is HIGH_CONTRAST
    assert palette_for("standard", None) is HIGH_CONTRAST
    with pytest.raises(ValueError, match=r"no palette 'pink': choose one of standard, colour-blind"):
        palette_for("pink", "truecolor")
