"""Where recordings and calibrations are kept: one place, whatever folder one stands in.

`--recordings`, else the folder `recordings` in `ARL_HOME`, else the one in the user's data folder.
"""

import os
from pathlib import Path

VARIABLE = "ARL_HOME"
RECORDINGS = "recordings"


def home() -> Path:
    """Return the folder of everything that this program keeps; it may not exist yet."""
    named = os.environ.get(VARIABLE, "").strip()
    if named:
        # As one writes it in a file where no shell replaces the tilde.
        return Path(named).expanduser().absolute()
    import platformdirs  # here: most commands are told a folder, or need none

    return platformdirs.user_data_path("arl", appauthor=False)


def recordings_folder() -> Path:
    """Return where recordings are kept unless `--recordings` says otherwise."""
    return home() / RECORDINGS


def why_here() -> str:
    """Return in words who chose `recordings_folder`."""
    return f"by {VARIABLE}" if os.environ.get(VARIABLE, "").strip() else f"the default; {VARIABLE} is not set"


def elsewhere(folder: Path) -> Path | None:
    """Return the folder `recordings` one stands in, where earlier versions kept all; None for none.

    Args:
        folder: the one that is used.
    """
    old = Path(RECORDINGS)
    if not old.is_dir() or old.resolve() == folder.resolve():
        return None
    return old if any(old.glob("*.jsonl")) or any(old.glob("calibration/*.jsonl")) else None
