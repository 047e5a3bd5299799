"""`arl compare`: sessions and groups of sessions beside each other."""

import csv
import math
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from arl_tui.command_line import ToWrite, say
from core.system.foreign_text import in_table, printable, printable_lines
from core.system.whole_file import whole_file

if TYPE_CHECKING:
    from studies.session_view.comparison import By, SessionFigures

LEVELS = "▁▂▃▄▅▆▇█"
LABEL = 24


@click.command(short_help="Compare sessions: participants, conditions or protocols.")
@click.argument(
    "files", nargs=-1, required=True, type=click.Path(exists=True, dir_okay=False, path_type=Path)
)
@click.option(
    "--by",
    type=click.Choice(["participant", "condition", "protocol"]),
    default="participant",
    show_default=True,
    help="What makes a group. Conditions and protocols are paired by participant, participants by game "
    "number.",
)
@click.option(
    "--csv", "csv_path", type=ToWrite(), help="Write a row for each game of every session to a file."
)
@click.option(
    "--plot", "plot_path", type=ToWrite(figure=True), help="Draw the groups over games (PNG, SVG or PDF)."
)
@click.option("--html", "html_path", type=ToWrite(), help="Write everything as one page.")
def compare(
    files: tuple[Path, ...],
    by: "By",
    csv_path: Path | None,
    plot_path: Path | None,
    html_path: Path | None,
) -> None:
    """Compare FILES, recordings of one game, session by session and group by group.

    Differences are to the first group, in the order of the files. docs/look-at-a-session.md explains every
    figure.
    """
    from studies.session_view.comparison import differences_of, game_rows, groups_of
    from studies.session_view.comparison_page import (
        EXPLAINED,
        difference_table,
        draw_comparison,
        group_table,
        origins_note,
        session_table,
        write_page,
    )
    from studies.statistics import few_trials_note

    sessions = _read(files)
    groups = groups_of(sessions, by)
    differences = list(differences_of(groups, by))
    _say("Sessions", *session_table(sessions), words=5)
    if note := origins_note(sessions):
        say(f"{note}\n")
    _say(f"Groups by {by}", *group_table(groups))
    if differences:
        _say("Differences to the first group", *difference_table(differences), words=2)
    few = few_trials_note(min(map(len, groups.values())), "sessions per group")
    if few is not None and by != "participant":
        say(f"{few}\n")
    say("\n".join(_curves(groups)))
    say("\n" + "\n".join(EXPLAINED))
    if csv_path is not None:
        _write(csv_path, list(game_rows(sessions, by)))
        say(f"Table: {csv_path}")
    if plot_path is not None:
        try:
            draw_comparison(groups).savefig(plot_path, dpi=150)
        except ValueError as error:
            raise click.BadParameter(f"{plot_path}: {error}", param_hint="--plot") from error
        say(f"Figure: {plot_path}")
    if html_path is not None:
        write_page(html_path, groups, differences, by)
        say(f"Page: {html_path}")


def _read(files: Sequence[Path]) -> "list[SessionFigures]":
    """Return all sessions in figures; stop where one cannot be read, or where they are of several games."""
    import msgspec

    from core.recording.reader import RecordingError
    from studies.session_view.comparison import NothingToCompareError, figures_of

    twice = next((path for n, path in enumerate(files) if path in files[:n]), None)
    if twice is not None:
        raise click.BadParameter(f"{twice} is named twice", param_hint="FILES")
    sessions: list[SessionFigures] = []
    with click.progressbar(files, label="Reading", file=sys.stderr) as shown:
        for path in shown:
            try:
                sessions.append(figures_of(path, own_delay_s=_own_delay_s(path)))
            except (RecordingError, NothingToCompareError, OSError) as error:
                raise click.ClickException(printable_lines(str(error))) from error
            except (msgspec.ValidationError, ValueError) as error:
                raise click.ClickException(
                    f"{path}: its protocol cannot be used: {printable(str(error))}"
                ) from error
    games = sorted({session.game for session in sessions})
    if len(games) > 1:
        raise click.ClickException(
            f"these are recordings of {' and '.join(games)}, whose figures cannot be compared: name files of "
            f"one game"
        )
    return sessions


def _own_delay_s(path: Path) -> float:
    """Return the mean of the participant's measured delay, seconds; NaN where there is none."""
    from arl_tui.commands.watch_recording import own_delay
    from studies.session_view.session import open_session

    delay = own_delay(path, open_session(path))
    return float(getattr(delay, "mean_s", math.nan))


def _say(title: str, head: Sequence[str], rows: Sequence[Sequence[str]], *, words: int = 1) -> None:
    """Print a table; the first columns are words, to the left. A column without any figure is left out."""
    kept = [
        place for place in range(len(head)) if place == 0 or any(row[place] not in ("-", "") for row in rows)
    ]
    table = [[row[place] for place in kept] for row in (head, *rows)]
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    say(title)
    for row in table:
        cells = [
            f"{cell:<{width}}" if kept[place] < words else f"{cell:>{width}}"
            for place, (cell, width) in enumerate(zip(row, widths, strict=True))
        ]
        say("  " + "  ".join(cells).rstrip())
    say()


def _curves(groups: "dict[str, list[SessionFigures]]") -> Iterator[str]:
    """Yield performance, presses, trust and weight over games, a line of bars for each group."""
    from studies.session_view.comparison import over_games
    from studies.session_view.comparison_page import PANELS

    for what, heading in PANELS:
        rows = {name: over_games(sessions, what) for name, sessions in groups.items()}
        known = [float(value) for row in rows.values() for value in row if not math.isnan(value)]
        if not known:
            continue
        low, high = min(0.0, *known), max(known)
        yield f"{heading}, by game; the highest bar is {high:.3g}"
        for name, row in rows.items():
            bars = "".join(
                " "
                if math.isnan(value)
                else LEVELS[round((value - low) / (high - low) * 7) if high > low else 0]
                for value in row
            )
            yield f"  {printable(name, longest=LABEL - 3):<{LABEL}}{bars}"


def _write(path: Path, rows: list[dict[str, object]]) -> None:
    with whole_file(path) as file:
        if not rows:
            return
        writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(map(in_table, rows))
