"""Films of a recording: pieces of what the viewer shows, as files."""

import json
from pathlib import Path

import click
import pytest
from click.testing import CliRunner
from PIL import Image

from arl_tui.cli import main
from arl_tui.viewer import film
from tests.arl_tui.test_viewer import Looking
from tests.studies.session_view.made import TETRIS

pytestmark = pytest.mark.jit


@pytest.fixture
def looking(tmp_path: Path) -> Looking:
    return Looking(TETRIS, tmp_path)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--at", "5", "--until", "2"), "a film from 5 s to 2 s has no end"),
        (("--until", "0"), "a film from 0 s to 0 s has no end"),
        (("--at", "47"), "lasts 46.3 s"),
    ],
)
def test_a_film_of_nothing_is_refused(options: tuple[str, ...], said: str, looking: Looking) -> None:
    done = CliRunner().invoke(
        main, ["watch", str(looking.path), "--export", str(looking.folder / "a.cast"), *options]
    )
    assert done.exit_code == 2
    assert said in " ".join(done.output.split())
    assert not (looking.folder / "a.cast").exists()


def test_a_film_as_gif_and_as_asciicast(looking: Looking) -> None:
    out = looking.folder / "film.gif"
    film.export_film(looking.viewing, out, begin_s=1.0, end_s=3.0, speed=2.0)
    with Image.open(out) as moving:
        assert moving.size == (1080, 720)
        assert moving.n_frames > 4
        total = 0
        for number in range(moving.n_frames):
            moving.seek(number)
            total += moving.info["duration"]
    assert total == pytest.approx(1100, abs=30)
    cast = looking.folder / "film.cast"
    film.export_film(looking.viewing, cast, begin_s=1.0, end_s=3.0)
    head, *changes = [json.loads(line) for line in cast.read_text().splitlines()]
    assert (head["version"], head["width"], head["height"]) == (2, 120, 40)
    assert all(kind == "o" for _, kind, _ in changes)
    times = [time_s for time_s, _, _ in changes]
    assert times == sorted(times)
    assert times[-1] == pytest.approx(2.1)


def test_an_asciicast_draws_what_the_viewer_shows(looking: Looking) -> None:
    import pyte

    cast = looking.folder / "film.cast"
    film.export_film(looking.viewing, cast, begin_s=3.0, end_s=4.0)
    terminal = pyte.Screen(120, 40)
    stream = pyte.Stream(terminal)
    for line in cast.read_text().splitlines()[1:]:
        stream.feed(json.loads(line)[2])
    shown = "\n".join(terminal.display)
    assert "Press 1 of 24" in shown
    assert "╭────── Game 1 ──────╮" in shown


def test_an_mp4_is_handed_to_ffmpeg_or_refused_with_advice(
    looking: Looking, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", str(looking.folder))
    with pytest.raises(click.ClickException, match="ffmpeg, which is not installed"):
        film.export_film(looking.viewing, looking.folder / "film.mp4", end_s=0.5)
    fake = looking.folder / "ffmpeg"
    fake.write_text('#!/bin/sh\n/bin/cat > "$(/usr/bin/dirname "$0")/raw"\n')
    fake.chmod(0o755)
    film.export_film(looking.viewing, looking.folder / "film.mp4", end_s=0.5)
    assert (looking.folder / "raw").stat().st_size == 6 * 1080 * 720 * 3


def test_a_gif_that_is_too_long_says_what_to_do(looking: Looking) -> None:
    with pytest.raises(click.ClickException, match="--until"):
        film.export_film(looking.viewing, looking.folder / "film.gif", speed=0.1)
    with pytest.raises(click.BadParameter, match=r"got '\.avi'"):
        film.export_film(looking.viewing, looking.folder / "film.avi")
