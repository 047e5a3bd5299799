"""Slow twin of core.tetris.game: a board is a set of (row, column), a piece a set of cells; nothing is looked
up."""

Cells = frozenset[tuple[int, int]]

DRAWINGS = {
    "I": ["XXXX"],
    "O": ["XX", "XX"],
    "T": [".X.", "XXX"],
    "Z": ["XX.", ".XX"],
    "S": [".XX", "XX."],
    "J": ["X..", "XXX"],
    "L": ["..X", "XXX"],
}
"""The pieces as they enter."""


def drawn(name: str) -> Cells:
    lines = DRAWINGS[name]
    return frozenset(
        (len(lines) - 1 - i, j) for i, line in enumerate(lines) for j, cell in enumerate(line) if cell == "X"
    )


def at(cells: Cells, row: int, column: int) -> Cells:
    """Move a shape so that its lowest row and leftmost column are these."""
    low, left = min(r for r, _ in cells), min(c for _, c in cells)
    return frozenset((r - low + row, c - left + column) for r, c in cells)


def size(cells: Cells) -> tuple[int, int]:
    rows, columns = [r for r, _ in cells], [c for _, c in cells]
    return max(rows) - min(rows) + 1, max(columns) - min(columns) + 1


def clockwise(cells: Cells) -> Cells:
    return frozenset((-c, r) for r, c in cells)


def free(wall: Cells, piece: Cells, columns: int) -> bool:
    return not wall & piece and all(r >= 0 and 0 <= c < columns for r, c in piece)


def enters(wall: Cells, name: str, rows: int, columns: int) -> Cells:
    shape = drawn(name)
    height, width = size(shape)
    row = rows - height
    while not free(wall, at(shape, row, (columns - width) // 2), columns):
        row += 1
    return at(shape, row, (columns - width) // 2)


def pushed(wall: Cells, piece: Cells, rows: int, columns: int, columns_wide: int) -> Cells:
    moved = frozenset((r + rows, c + columns) for r, c in piece)
    return moved if free(wall, moved, columns_wide) else piece


def turned(wall: Cells, piece: Cells, columns: int) -> Cells:
    row, left = min(r for r, _ in piece), min(c for _, c in piece)
    shape = clockwise(piece)
    (_, width_before), (_, width) = size(piece), size(shape)
    column = left + {-3: -1, -1: 0, 0: 0, 1: 0, 3: 1}[width_before - width]
    while column < 0:
        column += 1
    while column + width > columns:
        column -= 1
    target = at(shape, row, column)
    return target if free(wall, target, columns) else piece


def acted(wall: Cells, piece: Cells, primitive: str | None, columns: int) -> Cells:
    match primitive:
        case "left":
            return pushed(wall, piece, 0, -1, columns)
        case "right":
            return pushed(wall, piece, 0, 1, columns)
        case "rotate":
            return turned(wall, piece, columns)
        case "drop":
            while (lower := pushed(wall, piece, -1, 0, columns)) != piece:
                piece = lower
            return piece
        case _:
            return piece


def ticks_to_reach(wall: Cells, name: str, rows: int, columns: int) -> dict[Cells, int]:
    """Fewest ticks after which the piece can have come to rest as each set of cells: all plans, tick by
    tick."""
    rests: dict[Cells, int] = {}
    air = {enters(wall, name, rows, columns)}
    for tick in range(1, 3 * rows + 20):
        after = {
            acted(wall, piece, primitive, columns)
            for piece in air
            for primitive in (None, "left", "right", "rotate", "drop")
        }
        lower = {piece: pushed(wall, piece, -1, 0, columns) for piece in after}
        for piece, below in lower.items():
            if piece == below:
                rests.setdefault(piece, tick)
        air = {below for piece, below in lower.items() if piece != below}
    assert not air
    return rests


def straight_drops(wall: Cells, name: str, columns: int, above: int) -> set[Cells]:
    """Every set of cells that a piece, however turned, can take up falling straight down from row `above`."""
    shape, found = drawn(name), set()
    for _ in range(4):
        shape = clockwise(shape)
        for column in range(columns - size(shape)[1] + 1):
            found.add(acted(wall, at(shape, above, column), "drop", columns))
    return found


def cleared(cells: Cells, columns: int) -> tuple[Cells, list[int]]:
    """Take full rows away, one at a time from the top; their numbers before any went, ascending."""
    height = max((r for r, _ in cells), default=-1) + 1
    full = [row for row in range(height) if all((row, column) in cells for column in range(columns))]
    for row in reversed(full):
        cells = frozenset((r - (r > row), c) for r, c in cells if r != row)
    return cells, full
