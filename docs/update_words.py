"""Bring the catalogues of words (`arl_tui/locale`) up to date with the code, and compile them.

Run it after a change of any text that participants read: `python docs/update_words.py`. New texts are added
without a translation, texts that are gone are removed, and nothing is guessed ("fuzzy" entries).
"""

import ast
import io
from collections.abc import Iterator
from pathlib import Path

from babel.messages.catalog import Catalog
from babel.messages.mofile import write_mo
from babel.messages.pofile import read_po, write_po

ROOT = Path(__file__).resolve().parents[1]
LOCALE = ROOT / "arl_tui" / "locale"
KEYWORDS = {"tr": 1, "later": 1, "judging_text": 1, "Refusal": 1, "trn": 2, "later_n": 2}
"""Functions of texts (`arl_tui.language`): their first one or two arguments go into the catalogue."""
FOLDERS = ("arl_tui", "studies")
OF_THE_EXPERIMENTER = ("viewer", "watch.py", "monitor.py")
"""Pages that no participant sees: what their keys do is said in English."""


def extracted() -> Catalog:
    """Return every text in the code, with the files in which it stands."""
    catalogue = Catalog(project="arl-tui", fuzzy=False)
    for folder in FOLDERS:
        for path in sorted((ROOT / folder).rglob("*.py")):
            bindings = not set(path.parts) & set(OF_THE_EXPERIMENTER)
            for message in texts_in(path.read_text(encoding="utf-8"), bindings=bindings):
                catalogue.add(message, locations=[(str(path.relative_to(ROOT)), 0)])
    return catalogue


def texts_in(code: str, *, bindings: bool) -> Iterator[str | tuple[str, str]]:
    """Yield the texts in a module; pairs are for one and for several.

    Babel's own extraction does not look into f-strings before Python 3.12.

    Args:
        code: of the module.
        bindings: what the keys of its pages do is a text, too (`arl_tui.app.key_help`).
    """
    for node in ast.walk(ast.parse(code)):
        name = node.func.id if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) else ""
        if name == "Binding" and isinstance(node, ast.Call) and bindings:
            tooltips = [word.value for word in node.keywords if word.arg == "tooltip"]
            said = (tooltips or node.args[2:3])[0]
            if isinstance(said, ast.Constant) and isinstance(said.value, str):
                yield said.value
        if name in KEYWORDS and isinstance(node, ast.Call):
            given = [each.value for each in node.args[: KEYWORDS[name]] if isinstance(each, ast.Constant)]
            texts = tuple(text for text in given if isinstance(text, str))
            if len(texts) == KEYWORDS[name] and all(texts):
                yield texts[0] if len(texts) == 1 else (texts[0], texts[1])


def read(language: str) -> Catalog:
    """Return the catalogue of a language; an empty one where it is new."""
    path = po_file(language)
    if not path.exists():
        return Catalog(locale=language)
    with path.open("rb") as file:
        return read_po(file, locale=language)


def compiled(catalogue: Catalog) -> bytes:
    """Return what the program reads."""
    out = io.BytesIO()
    write_mo(out, catalogue)
    return out.getvalue()


def po_file(language: str) -> Path:
    """Return the file that translators edit."""
    return LOCALE / language / "LC_MESSAGES" / "arl.po"


def update(language: str) -> list[str]:
    """Write a language's catalogue anew, and return the texts that have no translation."""
    catalogue = read(language)
    catalogue.update(extracted(), no_fuzzy_matching=True)
    catalogue.obsolete.clear()
    path = po_file(language)
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("wb") as file:
        write_po(file, catalogue, width=110, no_location=False, include_lineno=False, sort_output=False)
    path.with_suffix(".mo").write_bytes(compiled(catalogue))
    return [str(message.id) for message in catalogue if message.id and not translated(message.string)]


def translated(text: str | tuple[str, ...] | None) -> bool:
    """Return whether a message has all its translations."""
    return all(text) if isinstance(text, tuple) else bool(text)


def main() -> None:
    """Update every language there is a folder of."""
    for folder in sorted(path for path in LOCALE.iterdir() if path.is_dir()):
        missing = update(folder.name)
        print(f"{folder.name}: {len(missing)} without a translation")
        for text in missing:
            print(f"  {text!r}")


if __name__ == "__main__":
    main()
