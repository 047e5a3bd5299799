"""Make the film and the picture of the README from the real screens: `python docs/film.py [FOLDER]`.

The program runs `arl demo` in a pseudo-terminal, keeps what stands on the screen some times a second, and draws each screen
with the font that comes with matplotlib. Needs what tests need (pexpect, pyte), and Pillow, which comes with matplotlib.
"""  # noqa: E501

import os
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import matplotlib
import pexpect
import pyte
from PIL import Image, ImageDraw, ImageFont

COLUMNS, LINES = 80, 24
FRAMES_PER_S = 4
LONGEST_S = 40
"""The film ends after this time of play."""
CELL = (9, 18)
"""Width and height of a cell in pixels."""
FONT_SIZE = 15
COLOURS = 64
"""In the film's palette."""
INK, PAPER = "#d8d8d8", "#121212"
NAMES = {
    "black": "#000000",
    "red": "#cc3333",
    "green": "#33aa33",
    "brown": "#bb9922",
    "blue": "#3366cc",
    "magenta": "#aa44aa",
    "cyan": "#33aaaa",
    "white": "#d8d8d8",
}
"""What pyte calls the colours of the terminal's own palette."""
EIGHTHS = "▁▂▃▄▅▆▇█"
Cells = list[list[tuple[str, str, str]]]
"""Character, ink and paper of each cell of a screen."""


def colour(name: str, otherwise: str) -> str:
    """Return a colour of pyte as Pillow writes it."""
    if name == "default":
        return otherwise
    return NAMES.get(name.removeprefix("bright"), f"#{name}" if len(name) == 6 else otherwise)


def cells_of(screen: Any) -> Cells:
    """Return what stands on a screen."""
    rows = []
    for line in range(LINES):
        row = []
        for column in range(COLUMNS):
            cell = screen.buffer[line][column]
            ink, paper = colour(cell.fg, INK), colour(cell.bg, PAPER)
            row.append((cell.data or " ", *((paper, ink) if cell.reverse else (ink, paper))))
        rows.append(row)
    return rows


def picture(cells: Cells) -> Image.Image:
    """Return a screen as a picture. Blocks are drawn as rectangles, so that no gaps are between them."""
    font = ImageFont.truetype(
        Path(matplotlib.get_data_path()) / "fonts" / "ttf" / "DejaVuSansMono.ttf", FONT_SIZE
    )
    width, height = CELL
    image = Image.new("RGB", (COLUMNS * width, LINES * height), PAPER)
    draw = ImageDraw.Draw(image)
    for line, row in enumerate(cells):
        for column, (text, ink, paper) in enumerate(row):
            left, top = column * width, line * height
            right, bottom = left + width - 1, top + height - 1
            if paper != PAPER:
                draw.rectangle((left, top, right, bottom), fill=paper)
            if text in EIGHTHS:
                part = height * (EIGHTHS.index(text) + 1) // 8
                draw.rectangle((left, bottom - part + 1, right, bottom), fill=ink)
            elif text == "▀":
                draw.rectangle((left, top, right, top + height // 2 - 1), fill=ink)
            elif text.strip():
                draw.text((left, top - 1), text, fill=ink, font=font)
    return image


def record(folder: Path) -> list[Cells]:
    """Play the demonstration; return its screens from the first moving piece on, `FRAMES_PER_S` of each second."""  # noqa: E501
    screen = pyte.Screen(COLUMNS, LINES)
    stream = pyte.ByteStream(screen)
    environment = {
        **os.environ,
        "ARL_HOME": str(folder),
        "TERM": "xterm-256color",
        "COLORTERM": "truecolor",
        "TEXTUAL_DISABLE_KITTY_KEY": "1",
    }
    for name in ("TMUX", "STY", "SSH_CONNECTION", "NO_COLOR", "COLUMNS", "LINES"):
        environment.pop(name, None)
    child = pexpect.spawn(
        sys.executable,
        ["-W", "ignore", "-m", "arl_tui", "demo", "--seed", "1"],
        dimensions=(LINES, COLUMNS),
        env=environment,
        timeout=600,
    )
    screens: list[Cells] = []
    began: float | None = None
    due = 0.0
    pressed = 0.0
    while began is None or time.monotonic() - began < LONGEST_S:
        try:
            stream.feed(child.read_nonblocking(65536, timeout=0.02))
        except pexpect.TIMEOUT:
            pass
        except pexpect.EOF:
            break
        text, now = "\n".join(screen.display), time.monotonic()
        playing = "Presses left" in text or "presses left" in text
        if began is None and playing:
            began = due = now
        if began is None and now - pressed > 1.0:
            child.send("\r")  # the start key
            pressed = now
        if began is not None and now >= due:
            screens.append(cells_of(screen))
            due += 1 / FRAMES_PER_S
    child.close(force=True)
    return screens


def save_film(screens: list[Cells], target: Path) -> None:
    """Write screens as a GIF; what stands still is one longer frame."""
    kept: list[Cells] = []
    durations: list[int] = []
    for cells in screens:
        if kept and cells == kept[-1]:
            durations[-1] += 1000 // FRAMES_PER_S
        else:
            kept.append(cells)
            durations.append(1000 // FRAMES_PER_S)
    pictures = [picture(cells) for cells in kept]
    palette = pictures[len(pictures) // 2].quantize(COLOURS)
    frames = [each.quantize(COLOURS, palette=palette, dither=Image.Dither.NONE) for each in pictures]
    frames[0].save(target, save_all=True, append_images=frames[1:], duration=durations, loop=0, optimize=True)


def main(into: Path) -> None:
    """Write session.gif and session.png."""
    into.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        screens = record(Path(folder))
    save_film(screens, into / "session.gif")
    picture(screens[len(screens) // 2]).save(into / "session.png", optimize=True)
    for name in ("session.gif", "session.png"):
        print(f"{into / name}: {(into / name).stat().st_size / 1000:.0f} kB, {len(screens)} screens")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent / "figures")
