"""Studies that come with the program, complete with texts: copied to a folder, they run as they are."""

from collections.abc import Mapping
from importlib import resources
from pathlib import Path

from core.session.protocol import Language
from core.system.whole_file import write_whole

READY = ("demo", "fig5", "fig6", "fig7")
"""demo: two conditions in ten minutes. fig5, fig6, fig7: the paper's figures with people."""


SENTENCES: Mapping[Language, Mapping[str, str]] = {
    "en": {},
    "de": {
        'title = "Teach a computer"\n': 'title = "Bringen Sie einem Computer etwas bei"\nlanguage = "de"\n',
        "I have read the information, and my questions have been answered.": (
            "Ich habe die Information gelesen, und meine Fragen sind beantwortet."
        ),
        "I agree to take part, and that my key presses are recorded.": (
            "Ich willige ein, teilzunehmen und dass meine Tastendrücke aufgezeichnet werden."
        ),
        "My data may be published in anonymous form.": (
            "Meine Daten dürfen in anonymer Form veröffentlicht werden."
        ),
    },
}
"""What a study file itself says to participants, by language; its texts are files of their own."""


def copy_ready_study(name: str, folder: Path, language: Language = "en") -> list[Path]:
    """Copy a ready study and its texts.

    Args:
        name: one of `READY`.
        folder: where the files go; made where it is missing.
        language: of everything that participants read.

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
    there = ready / "texts" if language == "en" else ready / "texts" / language
    names = sorted(text.name for text in there.iterdir() if f'"{text.name}"' in study)
    for english, translated in SENTENCES[language].items():
        study = study.replace(english, translated)
    contents = {folder / "study.toml": study}
    contents |= {folder / text: (there / text).read_text(encoding="utf-8") for text in names}
    for path in contents:
        if path.exists():
            raise FileExistsError(f"{path} is there already: choose an empty folder")
    folder.mkdir(parents=True, exist_ok=True)
    try:
        for path, content in contents.items():
            write_whole(path, content)
    except OSError:
        for path in contents:  # half a study would stand in the way of a whole one
            path.unlink(missing_ok=True)
        raise
    return list(contents)
