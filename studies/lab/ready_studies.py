"""Studies that come with the program, complete with texts: copied to a folder, they run as they are."""

import shutil
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path

READY = ("demo", "fig5", "fig6", "fig7")
"""demo: two conditions in ten minutes. fig5, fig6, fig7: the paper's figures with people."""


def copy_ready_study(name: str, folder: Path) -> list[Path]:
    """Copy a ready study and its texts.

    Args:
        name: one of `READY`.
        folder: where the files go; made where it is missing.

    Returns:
        The new files, the study file first.

    Raises:
        ValueError: there is no ready study of this name.
        FileExistsError: a file of that name is there already; nothing was copied.
        OSError: the folder cannot be written.
    """
    if name not in READY:
        raise ValueError(f"there is no ready study {name!r}: choose one of {', '.join(READY)}")
    ready = resources.files(__package__) / "ready"
    study = (ready / f"{name}.toml").read_text(encoding="utf-8")
    texts = [text for text in (ready / "texts").iterdir() if f'"{text.name}"' in study]
    sources: dict[Path, Traversable] = {folder / "study.toml": ready / f"{name}.toml"}
    sources |= {folder / text.name: text for text in sorted(texts, key=lambda text: text.name)}
    for path in sources:
        if path.exists():
            raise FileExistsError(f"{path} is there already: choose an empty folder")
    folder.mkdir(parents=True, exist_ok=True)
    for path, source in sources.items():
        with resources.as_file(source) as file:
            shutil.copyfile(file, path)
    return list(sources)
