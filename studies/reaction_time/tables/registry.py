"""The presets, and which of them reads a file."""

from pathlib import Path

from studies.reaction_time.tables.contract import Columns, ReadError, Reading, shown
from studies.reaction_time.tables.dmdx import Dmdx
from studies.reaction_time.tables.eprime import EPrime
from studies.reaction_time.tables.gorilla import Gorilla
from studies.reaction_time.tables.jspsych import JsPsych
from studies.reaction_time.tables.opensesame import OpenSesame
from studies.reaction_time.tables.plain import Plain
from studies.reaction_time.tables.plan import Preset, Source, read_by
from studies.reaction_time.tables.psychopy import PsychoPy
from studies.reaction_time.tables.qualtrics import Qualtrics

PRESETS: tuple[Preset, ...] = (PsychoPy(), JsPsych(), EPrime(), Gorilla(), OpenSesame(), Dmdx(), Qualtrics())
PLAIN = Plain()
NAMES = (*(preset.name for preset in PRESETS), PLAIN.name)


def preset_of(name: str) -> Preset:
    """Return the preset of a name; raise ReadError with the known ones."""
    for preset in (*PRESETS, PLAIN):
        if preset.name == name:
            return preset
    raise ReadError(f"no preset is called {shown(name)}; there are {', '.join(NAMES)}")


def read_file(path: Path, columns: Columns, preset: str | None = None) -> Reading:
    """Read a table by a preset, by its own marks, or by its columns' names.

    A file that is recognised is read by its preset unless `columns.rt` names a column: then it is read as a
    table, as it always was, and a note says so.

    Args:
        path: the file.
        columns: what is known of its columns.
        preset: "table", or the name of a program; None recognises.

    Raises:
        ReadError: the file does not fit the preset, or cannot be understood.
    """
    source = Source(path, columns)
    found = [(one, marks) for one in PRESETS if (marks := one.marks(source)) is not None]
    if preset is not None and preset != PLAIN.name:
        wanted = preset_of(preset)
        marks = next((words for one, words in found if one is wanted), None)
        if marks is None:
            theirs = f"; it looks like {found[0][0].title}'s (--from {found[0][0].name})" if found else ""
            raise ReadError(
                f"{path}: this is no file of {wanted.title}: it lacks that program's marks{theirs}"
            )
        return _read(wanted, source, marks)
    if found and preset is None and not columns.rt:
        return _read(found[0][0], source, found[0][1])
    if not source.header:
        _ = source.table  # says what is wrong with it as a table
    notes: tuple[str, ...] = ()
    if found and preset is None:
        one = found[0][0]
        notes = (
            (
                f"this looks like a file of {one.title} and is read as a table, because --column rt= names a"
                f" column: every row is a trial. --from {one.name} knows {one.title}'s time-outs, wrong"
                " answers and practice"
            ),
        )
    return _read(PLAIN, source, "by its columns' names", notes)


def _read(preset: Preset, source: Source, marks: str, notes: tuple[str, ...] = ()) -> Reading:
    plan = preset.plan(source, marks)
    return read_by(plan, source.columns, (*source.text.notes, *notes))
