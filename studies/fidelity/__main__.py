"""`python -m studies.fidelity PAGE`: the tables of docs/results/keepaway_fidelity.md, from the reference's
files.
"""

import argparse
import difflib
import os
import sys
from collections.abc import Sequence
from pathlib import Path

PAGE = Path("docs/results/keepaway_fidelity.md")


def main(arguments: Sequence[str] | None = None) -> int:
    """Write the page's tables anew, or compare them; return the exit status."""
    parser = argparse.ArgumentParser(prog="python -m studies.fidelity", description=__doc__)
    parser.add_argument("page", nargs="?", type=Path, default=PAGE, help=f"the page; {PAGE} by default")
    parser.add_argument(
        "--data", type=Path, help="folder of the reference's files; $ARL_DATA/keepaway by default"
    )
    parser.add_argument("--figures", type=Path, help="draw the distributions of durations into this folder")
    parser.add_argument("--check", action="store_true", help="write no page; status 1 where a table differs")
    chosen = parser.parse_args(arguments)
    data = chosen.data or data_folder()
    if data is None or not data.is_dir():
        parser.error(f"no folder with the reference's files: got {data}. Set ARL_DATA, or give --data")
    from studies.fidelity.page import PageError, renewed

    try:
        before = chosen.page.read_text(encoding="utf-8")
        after = renewed(before, data, chosen.figures, note)
    except (PageError, OSError) as error:
        parser.error(str(error))
    changes = list(
        difflib.unified_diff(before.splitlines(), after.splitlines(), "page", "now", lineterm="", n=0)
    )
    sys.stdout.write("\n".join(changes or [f"{chosen.page}: every table is as it was"]) + "\n")
    if chosen.check:
        return 1 if changes else 0
    chosen.page.write_text(after, encoding="utf-8")
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
