"""The tables and figures of `docs/results/keepaway_fidelity.md`, made from the reference's files.

The page is prose around tables. A table is known by the line of its head; only its rows are written anew.
"""

from collections.abc import Callable, Iterator
from pathlib import Path

from studies.fidelity import ce_curves, curves_page, learning_table, regions
from studies.fidelity.keepaway_fidelity import (
    DRAWN_PHASES,
    FINE_NAMES,
    SETTINGS,
    TABLE_HEAD,
    DurationComparison,
    compare,
    compare_fine,
    fine_row,
    table_row,
    write_figure,
)
from studies.fidelity.keepaway_rollouts import HOLDERS, Rollout, Start, read_episodes, roll_out

N_EPISODES = 2000
"""Episodes of ours per setting."""
ROOT_SEED = 11
FINE_HEAD = ("setting", "policy", *FINE_NAMES)
ROLLOUT_HEAD = ("start (n)", "after", "a keeper", "both", "a taker", "nobody", "over")
STARTS: dict[Start, str] = {
    "drop": "9 cycles after a drop",
    "both": "both can kick",
    "taker": "only takers can",
    "loose": "nobody can",
}
ROLLED_OUT = next(setting for setting in SETTINGS if setting.label == "v15_full_hold")
"""What is played on from logged states: a fixed policy with exact state."""

Row = tuple[str, ...]
Note = Callable[[str], None]


class PageError(ValueError):
    """The page has no such table, or the reference's files are not there."""


def comparisons(data: Path, note: Note) -> Iterator[tuple[DurationComparison, bool]]:
    """Play every setting beside the reference; yield it with whether phases are drawn anew in each episode.

    Args:
        data: folder of the reference's files.
        note: is called with the name of each setting before it is played.
    """
    for setting in (*SETTINGS, *DRAWN_PHASES):
        drawn = setting in DRAWN_PHASES
        note(f"{setting.name} {setting.policy}{', drawn phases' if drawn else ''}")
        yield compare(setting, data, N_EPISODES, ROOT_SEED), drawn


def fine_rows(data: Path, note: Note) -> list[Row]:
    """Return the rows under FINE_HEAD, of the settings with logged trajectories."""
    rows = []
    for setting in sorted(SETTINGS, key=lambda each: each.name, reverse=True):
        note(f"{setting.name} {setting.policy}, cycle by cycle")
        both = compare_fine(setting, data, ROOT_SEED)
        if both is not None:
            rows.append(fine_row(setting, *both))
    return rows


def rollout_rows(found: list[Rollout]) -> list[Row]:
    """Return the rows under ROLLOUT_HEAD: logged starts and, in brackets, ours with the difference in
    standard errors.
    """
    cells = {(each.start, each.cycles, each.holder): each for each in found}
    n = {each.start: each.n for each in found}
    rows: list[Row] = []
    for start, words in STARTS.items():
        for cycles in sorted({each.cycles for each in found if each.start == start}):
            at = [cells.get((start, cycles, name)) for name in HOLDERS]
            rows.append((f"{words} ({n[start]})", str(cycles), *(_rollout_cell(each) for each in at)))
    return rows


def _rollout_cell(each: Rollout | None) -> str:
    if each is None:
        return ""
    return f"{each.logged} ({each.expected:.0f}, {each.standard_errors:+.1f})"


def with_rows(page: str, head: Row, rows: list[Row], *, number: int = 0) -> str:
    """Return the page with other rows in one of its tables.

    Args:
        page: Markdown.
        head: of the table.
        rows: what stands below it from now on.
        number: which of the tables with this head, from 0.

    Raises:
        PageError: there are fewer tables with this head.
    """
    lines = page.split("\n")
    found = [k for k, line in enumerate(lines) if line == _line(head)]
    if len(found) <= number:
        raise PageError(f"need {number + 1} tables with the head {_line(head)!r}, the page has {len(found)}")
    first = found[number] + 2
    last = first
    while last < len(lines) and lines[last].startswith("|"):
        last += 1
    return "\n".join([*lines[:first], *map(_line, rows), *lines[last:]])


def _line(cells: Row) -> str:
    return "| " + " | ".join(cells) + " |" if all(cells) else "|" + "|".join(f" {c} " for c in cells) + "|"


def renewed(page: str, data: Path, figures: Path | None, note: Note) -> str:
    """Return the page with tables from the reference's files; draw the figures of durations.

    The table of learning is not among them (`with_learning`): its runs take most of an hour of computing.

    Args:
        page: Markdown.
        data: folder of the reference's files.
        figures: where the figures go; None draws none.
        note: is called with what is done next.

    Raises:
        PageError: a table is missing from the page.
        OSError: a file of the reference cannot be read.
    """
    rows: dict[bool, list[Row]] = {False: [], True: []}
    for comparison, drawn in comparisons(data, note):
        rows[drawn].append(table_row(comparison))
        if figures is not None and not drawn:
            write_figure(comparison, figures / f"keepaway_{comparison.setting.label}.png")
    by_name = sorted(rows[False], key=lambda row: row[0], reverse=True)
    page = with_rows(page, TABLE_HEAD, by_name)
    page = with_rows(page, TABLE_HEAD, rows[True], number=1)
    page = with_rows(page, FINE_HEAD, fine_rows(data, note))
    note(f"{ROLLED_OUT.name} {ROLLED_OUT.policy}, on from logged states")
    logged = read_episodes(data / f"{ROLLED_OUT.label}_traj.csv.gz")
    return with_rows(page, ROLLOUT_HEAD, rollout_rows(roll_out(ROLLED_OUT, logged)))


def with_learning(page: str, data: Path, workers: int) -> str:
    """Return the page with its table of learning, played anew by so many processes (one: most of an hour)."""
    seeds, runs = learning_table.learn_all(workers)
    rows = learning_table.learning_rows(seeds, runs, learning_table.read_reference(data))
    return with_rows(page, learning_table.HEAD, rows)


def with_regions(page: str, note: Note) -> str:
    """Return the page with its table of other regions and numbers, played anew."""
    rows = []
    for task in regions.TASKS:
        note(task)
        rows.append(regions.region_row(task))
    return with_rows(page, regions.HEAD, rows)


def with_curves(page: str, played: Path, published: Path, figures: Path | None) -> str:
    """Return the page of cross-entropy with its table, from runs that were kept; draw its figure.

    Args:
        page: Markdown.
        played: our runs, as `ce_curves.write_csv` writes them.
        published: the published runs.
        figures: where the figure goes; None draws none.
    """
    ours, theirs = ce_curves.read_csv(played), ce_curves.read_published(published)
    if figures is not None:
        ce_curves.draw(
            [point for point in ours if point.rules in curves_page.SHOWN_RULES],
            theirs,
            figures / "ce_curves.png",
        )
    return with_rows(page, curves_page.HEAD, curves_page.curve_rows(ours, theirs))
