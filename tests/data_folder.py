"""Where tests find real data: the folder named by ARL_DATA, or the one beside the checkout."""

import os
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parents[1]


def data_root() -> Path:
    """Return the folder of real data, whether or not it exists."""
    return Path(os.environ.get("ARL_DATA") or REPOSITORY / "../shared/data").resolve()


def data_folder(*parts: str) -> Path:
    """Return a folder of real data; skip the test, saying why, where it is missing."""
    folder = data_root().joinpath(*parts)
    if not folder.is_dir():
        pytest.skip(f"no real data at {folder}: set ARL_DATA to the folder that holds {'/'.join(parts)}")
    return folder


def data_files(*parts: str, pattern: str) -> list[Path]:
    """Return all files of a kind, sorted; empty where the folder is missing (for parametrising)."""
    return sorted(data_root().joinpath(*parts).glob(pattern))
