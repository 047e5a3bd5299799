"""What a drawn pitch is made of: inks, runs of characters, and the marks of each rendering."""

from dataclasses import dataclass
from typing import Final, Literal, get_args

Detail = Literal["ascii", "half", "braille"]
DETAILS: Final[tuple[Detail, ...]] = get_args(Detail)
"""From coarse to fine."""

# What a cell shows: the ink of its character, or the paper behind it.
(
    GRASS,
    STRIPE,
    LINE,
    SPOT,
    WORDS,
    PATH,
    FAINT,
    TRAIL,
    KEEPER,
    TAKER,
    BALL,
    KEEPER_NAME,
    TAKER_NAME,
    HOLDER_NAME,
    GOOD,
    BAD,
) = range(16)
INKS: Final = (
    "grass",
    "stripe",
    "line",
    "spot",
    "words",
    "path",
    "faint",
    "trail",
    "keeper",
    "taker",
    "ball",
    "keeper-name",
    "taker-name",
    "holder-name",
    "good",
    "bad",
)
"""Names of the inks above, by number."""

Run = tuple[str, int, int]
"""Characters that look alike: text, ink, paper."""
Row = tuple[Run, ...]

ASPECT: Final = 2.0
"""Height of a character over its width."""
STRIPE_M: Final = 2.5
"""Width of a mown stripe: eight on the paper's pitch, so that distances can be judged."""
LEAST_LINES: Final = 10
"""Lines inside the boundary below which names would hide each other."""
TICK_FROM, TICK_TO = 0.55, 1.2
"""Where the mark of a player's direction starts and ends, in lines from its centre."""
DISC_FROM: Final = 0.9
"""Radius of a player's body, in lines, from which it is drawn: smaller ones hide behind the name."""
PATH_GAP: Final = 1.0
"""Between two dots of a pass, in lines."""


@dataclass(frozen=True, slots=True)
class Mark:
    """Players to be marked for a moment: what a press was taken for."""

    players: tuple[int, ...]
    good: bool
    """Whether it was judged good."""


@dataclass(frozen=True, slots=True)
class Shape:
    """The size of a drawn pitch in characters, boundary included."""

    columns: int
    lines: int


@dataclass(frozen=True, slots=True)
class Marks:
    """The characters of one rendering."""

    across: int
    """Dots per character, side by side."""
    down: int
    """Dots per character, one above the other."""
    ball_across: int
    """Places of the ball per character, side by side."""
    ball_down: int
    balls: str
    """What a character looks like by the places that the ball fills, a bit for each: from the left, then
    down."""
    boundary: str
    """Corners (upper left, right, lower left, right), level and upright line."""


MARKS: Final[dict[Detail, Marks]] = {
    "ascii": Marks(1, 1, 1, 1, " o", "++++-|"),
    "half": Marks(1, 2, 1, 2, " ▀▄█", "┌┐└┘─│"),
    "braille": Marks(2, 4, 2, 2, " ▘▝▀▖▌▞▛▗▚▐▜▄▙▟█", "┌┐└┘─│"),
}
ASCII_DOTS: Final = {SPOT: "+", PATH: ".", FAINT: "'", TRAIL: "'"}
BRAILLE_BITS: Final = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))
"""Bits of the dots of a braille character, from the top, each row from the left."""
