"""Characters and dots of one picture of the pitch while it is being drawn."""

import math
from collections.abc import Iterator
from functools import lru_cache
from itertools import pairwise

from arl_tui.widgets.pitch_ink import (
    ASCII_DOTS,
    ASPECT,
    BAD,
    BALL,
    BRAILLE_BITS,
    DISC_FROM,
    FAINT,
    GOOD,
    GRASS,
    HOLDER_NAME,
    KEEPER,
    KEEPER_NAME,
    LINE,
    MARKS,
    PATH,
    PATH_GAP,
    SPOT,
    STRIPE,
    STRIPE_M,
    TAKER,
    TAKER_NAME,
    TICK_FROM,
    TICK_TO,
    TRAIL,
    WORDS,
    Detail,
    Mark,
    Row,
    Run,
    Shape,
)
from core.keepaway.picture import PitchFrame, Place
from core.keepaway.pitch import ONGOING, PLAYER_RADIUS

_NAMES = (KEEPER_NAME, TAKER_NAME, HOLDER_NAME)
Cell = tuple[str, int, int]
"""A character, its ink and its paper."""


@lru_cache(maxsize=16)
def _blank_row(columns: int, upright: str, paper: int) -> Row:
    return ((upright, LINE, paper), (" " * (columns - 2), paper, paper), (upright, LINE, paper))


@lru_cache(maxsize=1)
def _nearest_first() -> tuple[tuple[int, int], ...]:
    """Return steps (lines, columns) to cells around, nearest first."""
    steps = [(down, right) for down in range(-8, 9) for right in range(-16, 17)]
    return tuple(sorted(steps, key=lambda s: (math.hypot(s[0], s[1] / ASPECT), s)))


class Sheet:
    """Characters and dots of one picture while it is being drawn."""

    def __init__(self, frame: PitchFrame, shape: Shape, detail: Detail, mark: Mark | None = None) -> None:
        self.frame = frame
        self.mark = mark
        self.news = True
        """Whether the end of an episode lights up in the boundary."""
        self.shape = shape
        self.detail = detail
        self.marks = MARKS[detail]
        self.across, self.down = self.marks.across, self.marks.down
        self.columns_per_m = (shape.columns - 2) / frame.length_m
        self.lines_per_m = (shape.lines - 2) / frame.width_m
        self.texts: dict[int, dict[int, Cell]] = {}
        """By line and column: a character, its ink and its paper."""
        self.names: dict[int, tuple[int, int, int]] = {}
        """By player: column, line and length of the name."""
        self.dots: dict[int, dict[int, int]] = {}
        """By line and column of dots: ink."""
        self.ball: dict[int, dict[int, int]] = {}
        """By line and column: the places in a character that it fills (`Marks.balls`)."""

    # --- places ---------------------------------------------------------------------------------------------

    def point(self, x_m: float, y_m: float) -> Place:
        """Return (column, line) of a place, in characters from the top left corner, inside the drawing."""
        columns, lines = self.shape.columns, self.shape.lines
        column = 1 + (x_m + self.frame.length_m / 2) * self.columns_per_m
        line = 1 + (y_m + self.frame.width_m / 2) * self.lines_per_m
        return min(max(column, 0.0), columns - 1e-6), min(max(line, 0.0), lines - 1e-6)

    def dot(self, column: float, line: float, ink: int) -> None:
        """Put a dot where it is inside the drawing."""
        if 0 <= column < self.shape.columns and 0 <= line < self.shape.lines:
            self.dots.setdefault(int(line * self.down), {})[int(column * self.across)] = ink

    # --- what is drawn, from the bottom to the top ----------------------------------------------------------

    def write_names(self) -> None:
        """Write every player's name where the player is, or as near as there is room."""
        frame = self.frame
        order = sorted(range(len(frame.players)), key=lambda player: player != frame.holder)
        for player in order:
            view = frame.players[player]
            column, line = self.point(view.x_m, view.y_m)
            name = frame.name(player)
            keeper = player < frame.n_keepers
            ink = HOLDER_NAME if player == frame.holder else KEEPER_NAME if keeper else TAKER_NAME
            start, row = self._free_place(round(column - len(name) / 2), int(line), len(name))
            self.names[player] = (start, row, len(name))
            cells = self.texts.setdefault(row, {})
            for k, letter in enumerate(name):
                cells[start + k] = (letter, ink, WORDS if ink == HOLDER_NAME else KEEPER if keeper else TAKER)
        if self.mark is not None:
            self._mark_names(self.mark)

    def _mark_names(self, mark: Mark) -> None:
        """Write marked players' names in the colour of the judgement, between + or - where there is room."""
        paper, sign = (GOOD, "+") if mark.good else (BAD, "-")
        for player in mark.players:
            start, row, length = self.names[player]
            cells = self.texts[row]
            for column in range(start, start + length):
                cells[column] = (cells[column][0], WORDS, paper)
            for column in (start - 1, start + length):
                if 0 < column < self.shape.columns - 1:
                    cells.setdefault(column, (sign, WORDS, paper))

    def write_keys(self, options: tuple[tuple[int, str], ...]) -> None:
        """Write the key of an option beside the name of a player, lit up like the one who has the ball."""
        for player, key in options:
            start, row, length = self.names[player]
            label = f"[{key}]"
            place, line = self._free_place(start + length, row, len(label))
            cells = self.texts.setdefault(line, {})
            for k, letter in enumerate(label):
                cells[place + k] = (letter, HOLDER_NAME, WORDS)

    def _free_place(self, column: int, line: int, length: int) -> tuple[int, int]:
        for down, right in _nearest_first():
            row, start = line + down, column + right
            if 0 <= row < self.shape.lines and 0 <= start <= self.shape.columns - length:
                cells = self.texts.get(row, {})
                if not any(start + k in cells for k in range(length)):
                    return start, row
        return min(max(column, 0), self.shape.columns - length), line

    def dot_centre(self) -> None:
        """Mark the centre of the region."""
        self.dot(*self.point(0.0, 0.0), SPOT)

    def dot_pass(self) -> None:
        """Dot the way from the ball to the receiver; dots stay where they are while the ball rolls."""
        frame = self.frame
        if not frame.passing:
            return
        receiver = frame.players[frame.target]
        to_column, to_line = self.point(receiver.x_m, receiver.y_m)
        column, line = self.point(*frame.ball)
        across, down = column - to_column, line - to_line
        length = math.hypot(across / ASPECT, down)
        for k in range(1, int(length / PATH_GAP)):
            fraction = k * PATH_GAP / length
            self.dot(to_column + fraction * across, to_line + fraction * down, PATH)

    def dot_trail(self) -> None:
        """Draw where the ball has just been, its older half fainter."""
        places = [self.point(*place) for place in (*self.frame.trail, self.frame.ball)]
        for k, ((column, line), (to_column, to_line)) in enumerate(pairwise(places)):
            ink = FAINT if k < len(places) // 2 - 1 else TRAIL
            across, down = to_column - column, to_line - line
            steps = int(max(abs(across) * self.across, abs(down) * self.down)) + 1
            for j in range(steps):
                self.dot(column + across * j / steps, line + down * j / steps, ink)

    def dot_players(self) -> None:
        """Draw which way players face, and their bodies where these are larger than their names."""
        radius = PLAYER_RADIUS * self.lines_per_m
        for player, (start, row, length) in self.names.items():
            ink = KEEPER if player < self.frame.n_keepers else TAKER
            angle = math.radians(self.frame.players[player].body_deg)
            if self.detail == "ascii":
                self._arrow(start, row, length, angle, ink)
                if player == self.frame.holder:
                    self._write_if_free(start - 1, row, "[", WORDS)
                    self._write_if_free(start + length, row, "]", WORDS)
                continue
            column, line = start + length / 2, row + 0.5
            if radius > DISC_FROM:
                self._disc(column, line, radius, ink)
            steps = 2 * self.down
            for k in range(steps + 1):
                reach = max(TICK_FROM, radius) + (TICK_TO - TICK_FROM) * k / steps
                self.dot(column + ASPECT * reach * math.cos(angle), line + reach * math.sin(angle), ink)

    def _disc(self, column: float, line: float, radius: float, ink: int) -> None:
        n = math.ceil(radius * self.down)
        for i in range(-n, n + 1):
            for j in range(-n, n + 1):
                if i * i + j * j <= n * n:
                    self.dot(column + ASPECT * j / self.down, line + i / self.down, ink)

    def _arrow(self, start: int, line: int, length: int, angle: float, ink: int) -> None:
        """Write the direction beside a name, unless another name is there."""
        level = 0 if math.cos(angle) < 0 else length - 1
        right, down, letter = (
            (length, 0, ">"),
            (length, 1, "\\"),
            (level, 1, "v"),
            (-1, 1, "/"),
            (-1, 0, "<"),
            (-1, -1, "\\"),
            (level, -1, "^"),
            (length, -1, "/"),
        )[round(angle / (math.pi / 4)) % 8]
        self._write_if_free(start + right, line + down, letter, ink)

    def _write_if_free(self, column: int, line: int, letter: str, ink: int) -> None:
        if 0 <= column < self.shape.columns and 0 <= line < self.shape.lines:
            self.texts.setdefault(line, {}).setdefault(column, (letter, ink, self._paper(line)))

    def place_ball(self) -> None:
        """Draw the ball, beside the names if it is under one: as wide as a character and half as high, or a
        letter.
        """
        column, line = self.point(*self.frame.ball)
        across, down = self.marks.ball_across, self.marks.ball_down
        left = int(column) if across == 1 else round((column - 0.5) * across)
        top = int(line * down)
        for lower, further in _nearest_first():
            places = [(top + lower, left + further + k) for k in range(across)]
            if all(self._is_free(row // down, place // across) for row, place in places):
                break
        for row, place in places:
            cells = self.ball.setdefault(row // down, {})
            bit = 1 << (row % down * across + place % across)
            cells[place // across] = cells.get(place // across, 0) | bit

    def _is_free(self, line: int, column: int) -> bool:
        if not (0 <= line < self.shape.lines and 0 <= column < self.shape.columns):
            return False
        cell = self.texts.get(line, {}).get(column)
        return cell is None or (cell[1] not in _NAMES and cell[2] not in (GOOD, BAD))

    # --- rows -----------------------------------------------------------------------------------------------

    def _paper(self, line: int) -> int:
        """Return the grass of a line: mown in stripes."""
        return STRIPE if int((line - 0.5) / self.lines_per_m / STRIPE_M) % 2 else GRASS

    def row(self, line: int, edge: str | None) -> Row:
        """Return a line of the drawing; `edge` is its boundary if it is the first or the last."""
        paper, boundary = self._paper(line), self.marks.boundary
        texts, ball = self.texts.get(line, {}), self.ball.get(line, {})
        dots = [(k, self.dots[row]) for k in range(self.down) if (row := line * self.down + k) in self.dots]
        if edge is None and not (texts or dots or ball):
            return _blank_row(self.shape.columns, boundary[5], paper)
        cells: list[Cell]
        if edge is None:
            cells = [(" ", paper, paper)] * self.shape.columns
            cells[0] = cells[-1] = (boundary[5], LINE, paper)
        else:
            # How an episode ended is news, and lights up.
            ended = self.news and line > 0 and self.frame.ended != ONGOING
            words = (HOLDER_NAME, WORDS) if ended else (WORDS, paper)
            cells = [(letter, LINE, paper) if letter in boundary else (letter, *words) for letter in edge]
        for column, cell in self._characters(dots, paper):
            cells[column] = cell
        for column, cell in texts.items():
            cells[column] = cell
        for column, places in ball.items():
            cells[column] = (self.marks.balls[places], BALL, paper)
        return tuple(_runs(cells))

    def _characters(self, dots: list[tuple[int, dict[int, int]]], paper: int) -> Iterator[tuple[int, Cell]]:
        """Yield column and cell of the characters that a line's rows of dots make up."""
        if self.detail == "ascii":
            for _, row in dots:
                for column, ink in row.items():
                    yield column, (ASCII_DOTS[ink], ink, paper)
        elif self.detail == "half":
            halves: dict[int, list[int]] = {}
            for k, row in dots:
                for column, ink in row.items():
                    halves.setdefault(column, [-1, -1])[k] = ink
            for column, (upper, lower) in halves.items():
                yield column, _half(upper, lower, paper)
        else:
            bits: dict[int, tuple[int, int]] = {}
            for k, row in dots:
                for dot, ink in row.items():
                    seen, top = bits.get(dot // 2, (0, 0))
                    bits[dot // 2] = seen | BRAILLE_BITS[k][dot % 2], max(top, ink)
            for column, (pattern, ink) in bits.items():
                yield column, (chr(0x2800 + pattern), ink, paper)


def _half(upper: int, lower: int, paper: int) -> Cell:
    if upper == lower:
        return "█", upper, paper
    if upper < 0:
        return "▄", lower, paper
    return "▀", upper, paper if lower < 0 else lower


def _runs(cells: list[Cell]) -> Iterator[Run]:
    text, ink, paper = cells[0]
    for letter, next_ink, next_paper in cells[1:]:
        if next_ink == ink and next_paper == paper:
            text += letter
        else:
            yield text, ink, paper
            text, ink, paper = letter, next_ink, next_paper
    yield text, ink, paper
