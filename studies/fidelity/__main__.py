"""`python -m studies.fidelity PAGE`: the tables of docs/results/keepaway_fidelity.md, from the reference's
files.

`--part` says which tables:

tables: durations, fine statistics, courses (the default).
learning: 165 runs of 12 simulated hours, most of an hour of computing.
regions: other regions and numbers of players.
speed: measured now on this machine, and printed. The page keeps the run that compares both versions.
curves: table and figure of docs/decisions/cross-entropy-curves.md, from docs/figures/ce_curves.csv; with
`--play` after playing all runs again.
"""

import argparse
import difflib
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

PAGE = Path("docs/results/keepaway_fidelity.md")
CURVES_PAGE = Path("docs/decisions/cross-entropy-curves.md")
CURVES = Path("docs/figures/ce_curves.csv")
PUBLISHED = "tetris_ce_published_curves.csv"
"""In the folder that ARL_DATA names."""
PARTS = ("tables", "learning", "regions", "speed", "curves")


def main(arguments: Sequence[str] | None = None) -> int:
    """Write the page's tables anew, or compare them; return the exit status."""
    parser = _parser()
    chosen = parser.parse_args(arguments)
    data = chosen.data or data_folder()
    if chosen.part not in ("regions", "speed") and (data is None or not data.is_dir()):
        parser.error(f"no folder with the reference's files: got {data}. Set ARL_DATA, or give --data")
    if chosen.part == "speed":
        return _print_speed()
    page = chosen.page or (CURVES_PAGE if chosen.part == "curves" else PAGE)
    from studies.fidelity.page import PageError

    try:
        before = page.read_text(encoding="utf-8")
        after = _renewal(chosen, data)(before)
    except (PageError, OSError) as error:
        parser.error(str(error))
    changes = list(
        difflib.unified_diff(before.splitlines(), after.splitlines(), "page", "now", lineterm="", n=0)
    )
    sys.stdout.write("\n".join(changes or [f"{page}: every table is as it was"]) + "\n")
    if chosen.check:
        return 1 if changes else 0
    page.write_text(after, encoding="utf-8")
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m studies.fidelity",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "page", nargs="?", type=Path, help=f"the page; {PAGE} by default, {CURVES_PAGE} with --part curves"
    )
    parser.add_argument("--part", choices=PARTS, default="tables", help="which tables; see above")
    parser.add_argument(
        "--data",
        type=Path,
        help=f"folder of the reference's files; $ARL_DATA/keepaway by default. {PUBLISHED} is beside it",
    )
    parser.add_argument("--figures", type=Path, help="draw the part's figures into this folder")
    parser.add_argument("--check", action="store_true", help="write no page; status 1 where a table differs")
    parser.add_argument("--play", action="store_true", help="curves: play all runs again, and keep them")
    parser.add_argument("--workers", type=int, default=1, help="processes that play; 1 by default")
    return parser


def _renewal(chosen: argparse.Namespace, data: Path | None) -> Callable[[str], str]:
    """Return what makes the new page of the old one."""
    from studies.fidelity import page as pages

    if chosen.part == "regions":
        return lambda page: pages.with_regions(page, note)
    assert data is not None, "this was looked at"
    if chosen.part == "learning":
        return lambda page: pages.with_learning(page, data, chosen.workers)
    if chosen.part == "curves":
        played = CURVES if not chosen.play else _played_curves(chosen.workers)
        return lambda page: pages.with_curves(page, played, data.parent / PUBLISHED, chosen.figures)
    return lambda page: pages.renewed(page, data, chosen.figures, note)


def _played_curves(workers: int) -> Path:
    from studies.fidelity.ce_curves import RULES, run_curves, settings, write_csv

    note(f"{len(RULES)} sets of rules, each about a minute")
    write_csv((point for curve in run_curves(settings(RULES), workers) for point in curve), CURVES)
    return CURVES


def _print_speed() -> int:
    from studies.fidelity.regions import PLAYS, SPEED_HEAD, speed_row

    for row in (SPEED_HEAD, *map(speed_row, PLAYS)):
        sys.stdout.write("| " + " | ".join(row) + " |\n")
    return 0


def data_folder() -> Path | None:
    """Return the folder of Keepaway's reference in the data that ARL_DATA names; None where it names none."""
    root = os.environ.get("ARL_DATA")
    return Path(root) / "keepaway" if root else None


def note(text: str) -> None:
    """Say on standard error what is done next."""
    sys.stderr.write(f"{text} ...\n")


if __name__ == "__main__":
    raise SystemExit(main())
