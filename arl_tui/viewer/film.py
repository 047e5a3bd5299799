"""Saves what the viewer shows: the screen as SVG and PNG, a stretch of a session as GIF, MP4 or asciicast."""

import asyncio
import json
import shutil
import subprocess
import sys
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final, Protocol

import click
from PIL import Image

from arl_tui.command_line import say
from arl_tui.viewer.pictures import pictures_of
from arl_tui.viewer.raster import CELL, Cells, picture_of
from arl_tui.viewer.reading import Viewing
from arl_tui.viewer.screenshot import screen_cells
from core.numerics.clock import NS_PER_S, ManualClock

FILM_FRAMES_PER_S: Final = 10
"""Of a film."""
SIZE: Final = (120, 40)
"""Columns and lines of a film."""
MOST_GIF_FRAMES: Final = 3000
"""A GIF is put together in memory."""
ENDINGS: Final = (".gif", ".mp4", ".cast")


class _Film(Protocol):
    """Takes pictures in order."""

    def add(self, cells: Cells, at_s: float, lasts_s: float) -> None:
        """Take a picture that is shown from a time on, seconds since the film's beginning."""
        ...

    def close(self) -> None:
        """Finish the file."""
        ...


def export_film(
    viewing: Viewing, path: Path, *, begin_s: float = 0.0, end_s: float | None = None, speed: float = 1.0
) -> None:
    """Write a stretch of a session as a film, as the viewer shows it at 120 x 40.

    Args:
        viewing: the recording.
        path: ends in .gif, .mp4 or .cast.
        begin_s: where to begin, seconds after the session's beginning.
        end_s: where to end; at the session's end by default.
        speed: recorded seconds per second of the film.

    Raises:
        click.ClickException: the film cannot be made; the message says what to do.
    """
    if path.suffix.lower() not in ENDINGS:
        raise click.BadParameter(
            f"{path}: a film ends in one of {', '.join(ENDINGS)}, got {path.suffix!r}", param_hint="--export"
        )
    session = viewing.session
    whole_s = (session.end_ns - session.start_ns) / NS_PER_S
    end_s = whole_s if end_s is None else min(end_s, whole_s)
    n = int(max(0.0, end_s - begin_s) / speed * FILM_FRAMES_PER_S) + 1
    if path.suffix.lower() == ".gif" and n > MOST_GIF_FRAMES:
        raise click.ClickException(
            f"{path}: a GIF of {n:,} pictures; the most is {MOST_GIF_FRAMES:,}. Name a shorter stretch "
            "(--at, --until), a higher --speed, or a .cast, which has no limit"
        )
    times = [session.start_ns + round((begin_s + k * speed / FILM_FRAMES_PER_S) * NS_PER_S) for k in range(n)]
    with _opened(path) as film:
        asyncio.run(_filmed(viewing, times, film))
    say(f"Film: {path} ({n / FILM_FRAMES_PER_S:.1f} s)")


async def _filmed(viewing: Viewing, times: list[int], film: _Film) -> None:
    from arl_tui.viewer.app import ViewerApp
    from arl_tui.viewer.screen import ViewerScreen

    screen = ViewerScreen(viewing, pictures_of(viewing.session), clock=ManualClock(), colours="truecolor")
    app = ViewerApp(screen)
    async with app.run_test(size=SIZE) as pilot:
        await pilot.pause()
        while not (viewing.ready and viewing.warm):
            await asyncio.sleep(0.05)
        with click.progressbar(times, label="Filming", file=sys.__stderr__) as shown:
            since, last = 0.0, None
            for k, time_ns in enumerate(shown):
                screen.transport.seek(time_ns)
                screen.draw()
                cells = screen_cells(app)
                if last is not None and cells != last:
                    film.add(last, since, k / FILM_FRAMES_PER_S - since)
                    since = k / FILM_FRAMES_PER_S
                last = cells
            if last is not None:
                film.add(last, since, len(times) / FILM_FRAMES_PER_S - since)


@contextmanager
def _opened(path: Path) -> Iterator[_Film]:
    kinds: dict[str, Callable[[Path], _Film]] = {".gif": _Gif, ".mp4": _Mp4, ".cast": _Cast}
    film = kinds[path.suffix.lower()](path)
    yield film
    film.close()


class _Gif:
    def __init__(self, path: Path) -> None:
        self._path = path
        # Compressed: a minute of pictures takes some ten megabytes, not two gigabytes.
        self._pictures: list[bytes] = []
        self._lasts_ms: list[int] = []

    def add(self, cells: Cells, at_s: float, lasts_s: float) -> None:
        self._pictures.append(zlib.compress(picture_of(cells).tobytes(), 1))
        self._lasts_ms.append(max(20, round(lasts_s * 1000)))

    def close(self) -> None:
        size = (SIZE[0] * CELL[0], SIZE[1] * CELL[1])
        # One palette for all pictures, or each would be stored whole.
        some = self._pictures[:: max(1, len(self._pictures) // 12)]
        all_of_them = Image.new("RGB", (size[0], size[1] * len(some)))
        for place, packed in enumerate(some):
            all_of_them.paste(Image.frombytes("RGB", size, zlib.decompress(packed)), (0, place * size[1]))
        palette = all_of_them.quantize(255)

        def picture(packed: bytes) -> Image.Image:
            image = Image.frombytes("RGB", size, zlib.decompress(packed))
            return image.quantize(palette=palette, dither=Image.Dither.NONE)

        picture(self._pictures[0]).save(
            self._path,
            save_all=True,
            append_images=(picture(packed) for packed in self._pictures[1:]),
            duration=self._lasts_ms,
            loop=0,
        )


class _Mp4:
    def __init__(self, path: Path) -> None:
        ffmpeg = shutil.which("ffmpeg")
        if ffmpeg is None:
            raise click.ClickException(
                f"{path}: an MP4 is made by ffmpeg, which is not installed here. Install it (`apt install "
                f"ffmpeg`, "
                "`brew install ffmpeg`), or write a .gif or .cast"
            )
        size = f"{SIZE[0] * CELL[0]}x{SIZE[1] * CELL[1]}"
        self._path = path
        self._ffmpeg = subprocess.Popen(
            [ffmpeg, "-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24", "-s", size, "-r",
             str(FILM_FRAMES_PER_S), "-i", "-", "-pix_fmt", "yuv420p", str(path)],
            stdin=subprocess.PIPE, stderr=subprocess.PIPE,
        )  # fmt: skip

    def add(self, cells: Cells, at_s: float, lasts_s: float) -> None:
        picture = picture_of(cells).tobytes()
        assert self._ffmpeg.stdin is not None
        for _ in range(max(1, round(lasts_s * FILM_FRAMES_PER_S))):
            try:
                self._ffmpeg.stdin.write(picture)
            except BrokenPipeError:
                self.close()

    def close(self) -> None:
        _, said = self._ffmpeg.communicate()
        if self._ffmpeg.returncode:
            raise click.ClickException(f"{self._path}: ffmpeg failed: {said.decode(errors='replace')[-300:]}")


class _Cast:
    """Writes asciicast version 2: a line of facts, then a line for each change (asciinema's format)."""

    def __init__(self, path: Path) -> None:
        self._file = path.open("w", encoding="utf-8")
        head = {"version": 2, "width": SIZE[0], "height": SIZE[1], "env": {"TERM": "xterm-256color"}}
        self._file.write(json.dumps(head) + "\n")
        self._shown: Cells = []

    def add(self, cells: Cells, at_s: float, lasts_s: float) -> None:
        parts = [] if self._shown else ["\x1b[2J\x1b[?25l"]
        for row, line in enumerate(cells):
            if row >= len(self._shown) or line != self._shown[row]:
                parts.append(f"\x1b[{row + 1};1H{ansi_line(line)}")
        self._shown = cells
        self._file.write(json.dumps([round(at_s, 6), "o", "".join(parts)]) + "\n")
        self._end = at_s + lasts_s

    def close(self) -> None:
        # So that the last picture stays as long as it was shown.
        self._file.write(json.dumps([round(self._end, 6), "o", "\x1b[0m"]) + "\n")
        self._file.close()


def ansi_line(line: list[tuple[str, tuple[int, int, int], tuple[int, int, int], bool]]) -> str:
    """Return characters with their colours as a terminal obeys them."""
    parts: list[str] = []
    look = None
    for letter, front, back, bold in line:
        if (front, back, bold) != look:
            look = front, back, bold
            weight = "1;" if bold else ""
            parts.append(
                f"\x1b[0;{weight}38;2;{front[0]};{front[1]};{front[2]};48;2;{back[0]};{back[1]};{back[2]}m"
            )
        parts.append(letter)
    return "".join(parts)
