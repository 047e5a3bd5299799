"""Where a study's data lie: one folder per study, one folder per participant in it."""

from pathlib import Path, PurePath

SIMULATED = "-simulated"
"""Ends the name of the folder of simulated participants, so that their data are never among people's."""


def data_folder(home: Path, study: str, *, simulated: bool = False) -> Path:
    """Return the folder of a study's data.

    Args:
        home: where all data are kept.
        study: name of the study.
        simulated: of simulated participants.
    """
    return home / "studies" / (study + (SIMULATED if simulated else ""))


PARTICIPANTS = "participants"
"""Of the participants' folders in the folder of a study's data."""


def participant_folder(data: Path, code: str) -> Path:
    """Return the folder of one participant's files.

    Raises:
        ValueError: the code would lead out of the participants' folder, or into another participant's.
    """
    path = PurePath(code)
    if path.is_absolute() or not path.parts or ".." in path.parts:
        raise ValueError(f"{code!r} is no participant's code: it would name a folder elsewhere")
    return data / PARTICIPANTS / code


def group_folders(folder: Path) -> list[Path]:
    """Return the folders with the files of a participant's group: those of all participants of their study.

    Args:
        folder: of one participant of a study, or any other folder, which is its own group.
    """
    if folder.parent.name != PARTICIPANTS:
        return [folder]
    return sorted(path for path in folder.parent.iterdir() if path.is_dir())


def sitting_path(data: Path, code: str, sitting: int, attempt: int) -> Path:
    """Return the file of one attempt at a sitting, both from 0."""
    again = f"-attempt-{attempt + 1}" if attempt else ""
    return participant_folder(data, code) / f"sitting-{sitting + 1}{again}.jsonl"


def exports_folder(data: Path) -> Path:
    """Return the folder of exported tables, with a folder per participant where a table belongs to one."""
    return data / "exports"
