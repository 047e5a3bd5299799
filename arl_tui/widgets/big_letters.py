"""Words three lines high, for what must be seen from the corner of the eye."""

_GLYPHS: dict[str, tuple[str, ...]] = {
    "A": (" ## ", "#  #", "####", "#  #", "#  #"),
    "B": ("### ", "#  #", "### ", "#  #", "### "),
    "C": (" ###", "#   ", "#   ", "#   ", " ###"),
    "D": ("### ", "#  #", "#  #", "#  #", "### "),
    "E": ("####", "#   ", "### ", "#   ", "####"),
    "G": (" ###", "#   ", "# ##", "#  #", " ###"),
    "H": ("#  #", "#  #", "####", "#  #", "#  #"),
    "I": ("###", " # ", " # ", " # ", "###"),
    "K": ("#  #", "# # ", "##  ", "# # ", "#  #"),
    "L": ("#   ", "#   ", "#   ", "#   ", "####"),
    "N": ("#  #", "## #", "# ##", "#  #", "#  #"),
    "O": (" ## ", "#  #", "#  #", "#  #", " ## "),
    "R": ("### ", "#  #", "### ", "# # ", "#  #"),
    "S": (" ###", "#   ", " ## ", "   #", "### "),
    "T": ("###", " # ", " # ", " # ", " # "),
    "U": ("#  #", "#  #", "#  #", "#  #", " ## "),
    "Ü": ("#  #", "    ", "#  #", "#  #", " ## "),
    "V": ("# #", "# #", "# #", "# #", " # "),
    "Y": ("# #", "# #", " # ", " # ", " # "),
    "Z": ("####", "  # ", " #  ", "#   ", "####"),
    " ": ("  ",) * 5,
    "0": (" ## ", "#  #", "#  #", "#  #", " ## "),
    "1": (" # ", "## ", " # ", " # ", "###"),
    "2": ("### ", "   #", " ## ", "#   ", "####"),
    "3": ("### ", "   #", " ## ", "   #", "### "),
    "4": ("#  #", "#  #", "####", "   #", "   #"),
    "5": ("####", "#   ", "### ", "   #", "### "),
    "6": (" ## ", "#   ", "### ", "#  #", " ## "),
    "7": ("####", "   #", "  # ", " #  ", " #  "),
    "8": (" ## ", "#  #", " ## ", "#  #", " ## "),
    "9": (" ## ", "#  #", " ###", "   #", " ## "),
}
"""Five rows of dots per letter; two rows make one line of text."""

LINES = 3
_HALVES = {(False, False): " ", (True, False): "▀", (False, True): "▄", (True, True): "█"}


def big(word: str, *, narrow: bool = False) -> tuple[str, ...]:
    """Return `word` as three lines of equal length.

    Args:
        word: in letters that have been drawn.
        narrow: letters of four dots get three: for long words where there is little room.

    Raises:
        KeyError: a letter has not been drawn yet.
    """
    glyphs = [_GLYPHS[letter] for letter in word]
    if narrow:
        glyphs = [tuple(row[:2] + row[3:] if len(row) == 4 else row for row in glyph) for glyph in glyphs]
    dots = [" ".join(glyph[row] for glyph in glyphs) for row in range(5)]
    dots.append(" " * len(dots[0]))
    return tuple(
        "".join(
            _HALVES[above == "#", below == "#"]
            for above, below in zip(dots[2 * line], dots[2 * line + 1], strict=True)
        )
        for line in range(LINES)
    )
