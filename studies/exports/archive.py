"""A folder that can be deposited as it is: anonymised data, tables, what they mean, and checksums."""

import hashlib
import json
import shutil
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path

import msgspec

from core.recording.anonymise import Anonymising
from core.recording.json_schema import schema_of
from core.recording.reader import read_recording
from core.recording.schema import VERSION
from core.system.private_files import make_private_folder
from studies.exports.anonymise import Copies, anonymise
from studies.exports.bids import BidsSettings, export_bids
from studies.exports.minari import export_minari
from studies.exports.sources import find_sources
from studies.exports.tidy import ExportError, export_tidy, simulated_note
from studies.lab.questions import READY
from studies.lab.read import LoadedStudy, load_study

CHECKSUMS = "checksums.sha256"


@dataclass(frozen=True, slots=True, kw_only=True)
class ArchiveSettings:
    """What is written besides the data."""

    name: str = "Key presses and reaction times"
    authors: tuple[str, ...] = ()
    licence: str = ""
    study_file: Path | None = None
    """Its texts, questionnaires and protocol are copied with it."""
    lock_file: Path | None = None
    """Exact versions of everything that was installed; copied."""
    software: Mapping[str, str] = field(default_factory=dict)
    """Versions of this program, its games, Python and libraries."""


@dataclass(slots=True)
class Archive:
    """What came of it."""

    copies: Copies
    parts: dict[str, str] = field(default_factory=dict)
    """Each part of the folder with what it holds."""
    simulated: str = ""
    """Of simulated sessions in it, a sentence; new codes do not show them."""


def make_archive(place: Path, into: Path, how: Anonymising, settings: ArchiveSettings) -> Archive:
    """Write an archive of the data in a folder. Where it does not come to its end, nothing of it is left.

    Args:
        place: a folder of data.
        into: a new or an empty folder.
        how: how the data are anonymised.
        settings: what is written besides.

    Raises:
        ExportError: `into` is not empty, or there are no data.
        AnonymiseError, StudyError: see `anonymise` and `load_study`.
        OSError: something cannot be read or written.
    """
    if into.exists() and any(into.iterdir()):
        raise ExportError(f"{into} is not empty: name a new folder")
    new = not into.exists()
    try:
        return _archived(place, into, how, settings)
    except BaseException:  # an interrupt, too: half an archive would pass for a whole one
        shutil.rmtree(into, ignore_errors=True)
        if not new:
            into.mkdir()
        raise


def _archived(place: Path, into: Path, how: Anonymising, settings: ArchiveSettings) -> Archive:
    study = load_study(settings.study_file) if settings.study_file else None
    data = into / "data"
    copies = anonymise(place, data, how, questions=study.questionnaires if study else None)
    if not copies.made:
        raise ExportError(f"{place}: there is nothing that can be archived. {_first(copies)}".rstrip())
    archive = Archive(copies)
    archive.parts["data/"] = (
        "anonymised recordings, reaction trials and records of sittings, as `arl` reads and replays them"
    )
    archive.simulated = simulated_note(export_tidy(data, into / "tables").origins)
    _exports(data, into, settings, archive.parts)
    _format(into / "format", archive.parts)
    _protocols(data, into / "protocols", archive.parts)
    if study is not None:
        _study(study, into / "study", archive.parts)
    _software(into / "software", settings, archive.parts)
    (into / "README.md").write_text(_readme(settings, archive), encoding="utf-8")
    (into / CHECKSUMS).write_text("".join(_checksums(into)), encoding="utf-8")
    return archive


def _first(copies: Copies) -> str:
    return str(next(iter((*copies.damaged, *copies.left_out)), "It holds no recordings"))


def _exports(data: Path, into: Path, settings: ArchiveSettings, parts: dict[str, str]) -> None:
    """Write BIDS and Minari beside the tables."""
    parts["tables/"] = (
        "the same as tidy tables (CSV); `codebook.md` and `codebook.json` say what each column means"
    )
    if any(source.kind in ("recording", "trials") for source in find_sources(data)):
        about = BidsSettings(name=settings.name, authors=settings.authors, licence=settings.licence)
        export_bids(data, into / "bids", about)
        parts["bids/"] = "the same as a BIDS data set"
    if find_spec("minari") is None:
        return
    try:
        export_minari(data, into / "minari")
    except ExportError:
        return  # no games: reaction trials only, or imported logs
    parts["minari/"] = "watched games as Minari data sets; set MINARI_DATASETS_PATH to this folder"


def _format(folder: Path, parts: dict[str, str]) -> None:
    make_private_folder(folder)
    for version in range(1, VERSION + 1):
        text = json.dumps(schema_of(version), indent=2, ensure_ascii=False)
        (folder / f"recording-version-{version}.schema.json").write_text(text + "\n", encoding="utf-8")
    parts["format/"] = "JSON Schema of one line of a recording, for each version of the format"


def _protocols(data: Path, folder: Path, parts: dict[str, str]) -> None:
    """Write each protocol of the recordings once, under its hash."""
    make_private_folder(folder)
    for source in find_sources(data):
        if source.kind == "recording":
            protocol = read_recording(source.path).header.protocol
            text = msgspec.json.format(msgspec.json.encode(protocol, order="sorted"), indent=2)
            path = folder / f"{hashlib.sha256(text).hexdigest()[:12]}.json"
            if not path.exists():
                path.write_bytes(text + b"\n")
    parts["protocols/"] = (
        "each protocol of the sessions once, complete; `tables/settings.csv` says which session had what"
    )


def _study(study: LoadedStudy, folder: Path, parts: dict[str, str]) -> None:
    beside = {*study.texts, *(name for name in study.questionnaires if name not in READY)}
    beside |= {study.study.protocol_file} - {"", None}
    for name in ("", *sorted(str(each) for each in beside)):
        source = study.path.parent / name if name else study.path
        target = folder / (name or study.path.name)
        if not target.resolve().is_relative_to(folder.resolve()):
            raise ExportError(
                f"{study.path}: {name} lies outside the study's folder: copy it beside the study file"
            )
        make_private_folder(target.parent)
        target.write_bytes(source.read_bytes())
    parts["study/"] = "the study file with its texts, questionnaires and protocol"


def _software(folder: Path, settings: ArchiveSettings, parts: dict[str, str]) -> None:
    make_private_folder(folder)
    text = json.dumps(dict(settings.software), indent=2)
    (folder / "versions.json").write_text(text + "\n", encoding="utf-8")
    found = {
        f"{distribution.metadata['Name']}=={distribution.version}"
        for distribution in metadata.distributions()
    }
    (folder / "installed.txt").write_text("\n".join(sorted(found, key=str.lower)) + "\n", encoding="utf-8")
    said = "versions of the program that wrote this archive, and of everything installed beside it"
    if settings.lock_file is not None and settings.lock_file.is_file():
        (folder / settings.lock_file.name).write_bytes(settings.lock_file.read_bytes())
        said += "; its lock file"
    parts["software/"] = said


def _readme(settings: ArchiveSettings, archive: Archive) -> str:
    authors = ", ".join(settings.authors) or "(not stated)"
    n_files = len(archive.copies.made)
    left_out = [*archive.copies.left_out, *archive.copies.damaged]
    lines = [
        f"# {settings.name}",
        "",
        f"Authors: {authors}. Licence: {settings.licence or '(not stated)'}.",
        f"Made by `arl archive`, arl-tui {settings.software.get('arl-tui', '')}.".replace(" .", "."),
        "",
        "| part | holds |",
        "|---|---|",
        *(f"| `{name}` | {what} |" for name, what in archive.parts.items()),
        f"| `{CHECKSUMS}` | SHA-256 of every file: `sha256sum -c {CHECKSUMS}` |",
        "",
        (
            f"{n_files} files of data were anonymised. Each says in its header what was removed, and names the "  # noqa: E501
            f"file it was"
        ),
        (
            "made from by a hash. Participants have new codes; the key by which they follow from the old ones "  # noqa: E501
            "is not here."
        ),
        "",
        "A session is replayed exactly by `arl replay data/FILE`, with the versions in `software/`.",
    ]
    if archive.simulated:
        lines += ["", f"**{archive.simulated}**"]
    if left_out:
        lines += [
            "",
            f"{len(left_out)} files of the folder were not archived: they are of other kinds, or damaged.",
        ]
    return "\n".join(lines) + "\n"


def _checksums(folder: Path) -> Iterator[str]:
    for path in sorted(path for path in folder.rglob("*") if path.is_file()):
        digest = hashlib.sha256(path.read_bytes()).hexdigest()
        yield f"{digest}  {path.relative_to(folder).as_posix()}\n"
