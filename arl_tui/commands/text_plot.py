"""Plots of plain text for standard output: a histogram with densities, and a Q-Q plot. Numbers in, lines
out.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from core.numerics.arrays import Floats

EIGHTHS = " ▏▎▍▌▋▊▉█"
MARKS = "○●◆"
"""One per density."""
_BRAILLE = 0x2800
_DOTS = np.array([[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]])
"""Bits of the dots of a braille cell, shape (4 rows, 2 columns)."""


def histogram_edges(times_s: Floats, most: int = 18) -> Floats:
    """Return edges of bins of a round width (1, 2 or 5 times a power of ten), at most `most` bins,
    seconds.
    """
    low, high = float(times_s.min()), float(times_s.max())
    wanted = max((high - low) / most, 1e-6)
    power = 10.0 ** np.floor(np.log10(wanted))
    width = next(
        power * step for step in (1.0, 2.0, 5.0, 10.0, 20.0) if _n_bins(low, high, power * step) <= most
    )
    first = np.floor(low / width)
    return np.asarray((first + np.arange(_n_bins(low, high, width) + 1)) * width)


def _n_bins(low: float, high: float, width: float) -> int:
    return int(np.floor(high / width) - np.floor(low / width)) + 1


def histogram(
    edges: Floats, heights: Floats, densities: Mapping[str, Floats], *, width: int = 60
) -> list[str]:
    """Return a histogram lying on its side: one line per bin, a bar for what was seen, a mark per density.

    Args:
        edges: of the bins in seconds, shape (n + 1,).
        heights: of the bars, per second, shape (n,), >= 0.
        densities: name to the density's mean over each bin, per second, shape (n,); at most as many as
            `MARKS`.
        width: columns of the longest bar.
    """
    top = max(float(heights.max()), *(float(d.max()) for d in densities.values()), 1e-12)
    digits = max(2, -int(np.floor(np.log10(edges[1] - edges[0]) + 1e-9)))
    lines = []
    for i, height in enumerate(heights):
        cells = list(bar(float(height) / top, width))
        for mark, density in zip(MARKS, densities.values(), strict=False):
            cells[min(int(density[i] / top * width), width - 1)] = mark
        label = f"{edges[i]:.{digits}f}-{edges[i + 1]:.{digits}f} s"
        lines.append(f"{label:>14} │{''.join(cells).rstrip()}")
    legend = "  ".join(f"{mark} {name}" for mark, name in zip(MARKS, densities, strict=False))
    return [*lines, f"{'':>14} └ fraction of all trials per second, longest {top:.2f}   {legend}".rstrip()]


def bar(fraction: float, width: int) -> str:
    """Return a bar over `fraction` (0 to 1) of `width` columns, to an eighth of a column, padded with
    spaces.
    """
    eighths = round(min(max(fraction, 0.0), 1.0) * width * 8)
    full, rest = divmod(eighths, 8)
    return ("█" * full + (EIGHTHS[rest] if rest else "")).ljust(width)


def scatter(x: Floats, y: Floats, *, columns: int = 34, rows: int = 13) -> list[str]:
    """Return points over the square from the smallest to the largest value of both, with its diagonal.

    Args:
        x: horizontal positions, shape (n,), n >= 1.
        y: vertical positions, shape (n,); up is more.
        columns: width in cells, two dots each.
        rows: height in cells, four dots each.
    """
    low = min(float(x.min()), float(y.min()))
    span = max(float(x.max()), float(y.max()), low + 1e-12) - low
    dots = np.zeros((rows, columns), dtype=int)
    right = np.clip(((x - low) / span * (2 * columns - 1)).round().astype(int), 0, 2 * columns - 1)
    down = np.clip(((1.0 - (y - low) / span) * (4 * rows - 1)).round().astype(int), 0, 4 * rows - 1)
    np.bitwise_or.at(dots, (down // 4, right // 2), _DOTS[down % 4, right % 2])
    lines = []
    for row in range(rows):
        cells = [chr(_BRAILLE + bits) if bits else " " for bits in dots[row]]
        diagonal = round((1.0 - (row + 0.5) / rows) * columns - 0.5)
        if cells[diagonal] == " ":
            cells[diagonal] = "·"
        lines.append("│" + "".join(cells))
    ends = f"{low:.2f}".ljust(columns - 4) + f"{low + span:.2f}"
    return [*lines, "└" + "─" * columns, " " + ends]


def beside(left: Sequence[str], right: Sequence[str], *, gap: int = 3) -> list[str]:
    """Return two blocks of lines side by side."""
    width = max(map(len, left), default=0) + gap
    n_lines = max(len(left), len(right))
    pairs = zip([*left, *[""] * (n_lines - len(left))], [*right, *[""] * (n_lines - len(right))], strict=True)
    return [(a.ljust(width) + b).rstrip() for a, b in pairs]
