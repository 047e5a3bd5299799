"""What an importer is, and where other packages' are found: the entry point group `arl.importers`.

An importer turns other programs' files into recordings. A package that has one names an instance in its
metadata,

    [project.entry-points."arl.importers"]
    our-lab = "our_package.importer:IMPORTER"

and `arl import our-lab SOURCE` runs it. See `docs/importers.md`.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import Protocol, runtime_checkable

GROUP = "arl.importers"
BUILT_IN = {
    "tamer-log": "core.recording.importers.tamer_log:IMPORTER",
    "evaluations": "studies.evaluations.importer:IMPORTER",
}
"""Name to where the program's own importers are; found whatever the installation's metadata say."""


class ImporterError(ValueError):
    """A source cannot be imported; the message says where (file and line), what came and what to do."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Imported:
    """What an importer made."""

    recordings: tuple[Path, ...]
    """The recordings written, in the order of the source."""
    lines: tuple[str, ...]
    """What was found, mended and left out, with counts; printed line by line."""


@runtime_checkable
class Importer(Protocol):
    """Turns a source into recordings whose events are those of `core.events`."""

    name: str
    """What `arl import` calls it: lower case, digits and '-'."""
    summary: str
    """One line for the help."""
    settings: Mapping[str, str]
    """Each setting that `run` understands, and what it means; others never reach `run`."""

    def run(self, source: Path, folder: Path, settings: Mapping[str, str]) -> Imported:
        """Write the recordings of a source into a folder.

        Args:
            source: the file or folder to import.
            folder: where recordings go; made if it is not there. Existing files are never touched.
            settings: values by name, of the names in `self.settings` only.

        Returns:
            What was written. Everything in the source is in the recordings or counted in `lines`.

        Raises:
            ImporterError: the source cannot be understood. No file is left behind then.
            FileExistsError: there is such a recording already.
        """


def importer_names() -> dict[str, str]:
    """Return every importer's name and where it is, the program's own first, without loading any.

    Raises:
        ImporterError: two packages have an importer of one name.
    """
    found = dict(BUILT_IN)
    for point in entry_points(group=GROUP):
        if found.setdefault(point.name, point.value) != point.value:
            raise ImporterError(
                f"two importers are called {point.name!r}: {found[point.name]} and {point.value}. Uninstall"
                " one of their packages"
            )
    return found


def load_importer(name: str) -> Importer:
    """Return an importer.

    Raises:
        ImporterError: there is none of that name, its module cannot be imported, or it lacks a part of the
    contract.
    """
    names = importer_names()
    if name not in names:
        raise ImporterError(f"no importer is called {name!r}; there are {', '.join(names)}")
    try:
        importer = EntryPoint(name, names[name], GROUP).load()
    except (ImportError, AttributeError) as error:
        raise ImporterError(f"the importer {name!r} at {names[name]} cannot be loaded: {error}") from error
    if not isinstance(importer, Importer):
        raise ImporterError(
            f"{names[name]} is no importer: it needs name, summary, settings and run (docs/importers.md)"
        )
    return importer


def checked_settings(importer: Importer, settings: Mapping[str, str]) -> Mapping[str, str]:
    """Return the settings if the importer knows all of them; raise ImporterError otherwise."""
    for name in settings:
        if name not in importer.settings:
            known = ", ".join(importer.settings) or "none"
            raise ImporterError(f"{importer.name} has no setting {name!r}; there are {known}")
    return settings
