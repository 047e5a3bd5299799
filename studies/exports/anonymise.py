"""Anonymised copies of a whole folder of data: recordings, reaction trials and records of sittings."""

import re
import secrets
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import msgspec

from core.recording.anonymise import NO_DATE, NO_TEXT, Anonymising, anonymised, last_chain
from core.recording.chain import Chain
from core.recording.joined import older_path
from core.recording.reader import Recording, RecordingError, read_recording
from core.system.private_files import make_private_folder, write_private
from studies.exports.sources import Source, Trouble, find_sources
from studies.lab.questions import READY, FreeText, QuestionList, read_questions
from studies.lab.sealed import SealedFileError
from studies.lab.sitting_log import (
    ConsentAnswered,
    FileRecorded,
    QuestionAnswered,
    SittingClosed,
    SittingHeader,
    SittingLine,
    read_sitting,
)
from studies.reaction_time.trial_log import TrialFile, TrialFileError, read_trials

KEY_BYTES = 32


class AnonymiseError(ValueError):
    """Copies cannot be made; the message says why and what to do."""


@dataclass(slots=True)
class Copies:
    """What came of it."""

    made: list[tuple[Path, Path]] = field(default_factory=list)
    """Pairs of an old file and its copy."""
    left_out: list[Trouble] = field(default_factory=list)
    """Files that have no copy by intention: they hold codes and dates, or follow from the others."""
    damaged: list[Trouble] = field(default_factory=list)
    """Files that could not be read."""


def read_or_make_key(path: Path, *, apart_from: Iterable[Path]) -> bytes:
    """Return the secret key in a file; a new one, written there, where there is no such file.

    Args:
        path: of the key: a line of 64 hex digits.
        apart_from: folders in which a key must not lie: a recipient of them must not get it.

    Raises:
        AnonymiseError: the key would lie among the data, or the file holds no key.
        OSError: it cannot be read or written.
    """
    for folder in apart_from:
        if path.resolve().is_relative_to(folder.resolve()):
            raise AnonymiseError(
                f"{path}: the key would lie in {folder}, beside the data: with it everybody's old code can "
                "be found again. Keep it elsewhere, under lock"
            )
    if not path.exists():
        key = secrets.token_bytes(KEY_BYTES)
        make_private_folder(path.parent)
        write_private(path, key.hex().encode() + b"\n")
        return key
    try:
        with path.open(encoding="ascii") as file:
            key = bytes.fromhex(file.read(1 << 12).strip())
    except ValueError:
        key = b""
    if len(key) != KEY_BYTES:
        raise AnonymiseError(
            f"{path}: expected a key, a line of {2 * KEY_BYTES} hex digits, found something else. Name the "
            "file that `arl anonymise` made, or a new one"
        )
    return key


def anonymise(
    place: Path, into: Path, how: Anonymising, *, questions: Mapping[str, QuestionList] | None = None
) -> Copies:
    """Copy everything in a folder, or one file, anonymised.

    Recordings and trials get names of the new code and a number, in the order in which they were made; the
    folders of a study's participants get the new codes.

    Args:
        place: a folder or a file.
        into: a new or an empty folder.
        how: what is removed.
        questions: questionnaires by name: typed answers are found by them. The ready ones are known.

    Raises:
        AnonymiseError: `into` is not empty or lies in `place`, or two participants would get one code.
        OSError: something cannot be read or written.
    """
    if into.exists() and any(into.iterdir()):
        raise AnonymiseError(f"{into} is not empty: name a new folder")
    if place.is_dir() and into.resolve().is_relative_to(place.resolve()):
        raise AnonymiseError(f"{into} lies in {place}: name a folder elsewhere")
    copies, found = Copies(), []
    for source in find_sources(place):
        try:
            found.append(_read(source))
        except (RecordingError, TrialFileError, SealedFileError) as error:
            copies.damaged.append(Trouble(source.path, str(error)))
        except _Other as other:
            copies.left_out.append(Trouble(source.path, str(other)))
    names = _new_names(found, how)
    texts = {**{name: read_questions(name, Path()) for name in READY}, **(questions or {})}
    chains: dict[Path, str] = {}
    for one in sorted(found, key=lambda one: (one.when, one.source.path)):
        target = into / names[one.source.path]
        make_private_folder(target.parent)
        content = _copy(one, how, names, texts, chains)
        write_private(target, content)
        chains[one.source.path] = last_chain(content)
        copies.made.append((one.source.path, target))
    return copies


class _Other(Exception):
    """A file of another kind."""


@dataclass(frozen=True, slots=True)
class _Found:
    """A file by what naming needs; its content is read again when it is copied."""

    source: Source
    code: str
    when: str
    task: str = ""


def _read(source: Source) -> _Found:
    match source.kind:
        case "recording":
            header = read_recording(source.path).header
            return _Found(source, header.participant, header.created_utc)
        case "trials":
            trials = read_trials(source.path).header
            task = re.sub(r"\W+", "-", trials.schedule.config.task)
            return _Found(source, trials.participant, trials.created_utc, task)
        case "sitting":
            sitting, _ = read_sitting(source.path)
            return _Found(source, sitting.participant, sitting.at_utc)
        case _:
            raise _Other(
                f"{source.path}: {source.format or 'no format of ours'}: no copy is made; it is no "
                "recording, no reaction trials and no sitting"
            )


def _new_names(found: list[_Found], how: Anonymising) -> dict[Path, Path]:
    """Return the new name of each file, below the new folder."""
    codes = {one.code: how.code(one.code) for one in found}
    if len(set(codes.values())) < len(codes):
        raise AnonymiseError("two participants would get the same new code: take another key")
    names: dict[Path, Path] = {}
    numbers: dict[tuple[str, str], int] = {}
    for one in sorted(found, key=lambda one: (one.when, one.source.path)):
        code = codes[one.code]
        folder = Path(*(codes.get(part, part) for part in one.source.relative.parent.parts))
        name = one.source.relative.name
        if one.source.kind != "sitting":
            number = numbers[code, one.task] = numbers.get((code, one.task), 0) + 1
            name = "-".join(filter(None, (re.sub(r"[^\w-]", "_", code), one.task, str(number)))) + ".jsonl"
        names[one.source.path] = folder / name
    return names


def _copy(
    one: _Found,
    how: Anonymising,
    names: Mapping[Path, Path],
    questions: Mapping[str, QuestionList],
    chains: Mapping[Path, str],
) -> bytes:
    """Return the content of a copy; `chains` holds the last chains of the older copies."""
    path = one.source.path
    match one.source.kind:
        case "recording":
            recording: Recording = read_recording(path)
            resumes = recording.header.resumes
            if resumes is not None and (older := older_path(path, resumes)) in chains:
                resumes = msgspec.structs.replace(resumes, file=names[older].name, chain=chains[older])
            return anonymised(recording, how, resumes=resumes)
        case "trials":
            return _trials(read_trials(path), how, path.read_bytes())
        case _:
            header, lines = read_sitting(path)
            beside = {old.name: new.name for old, new in names.items() if old.parent == path.parent}
            about = how.about(path.read_bytes())
            return _sitting(header, lines, how, _Sitting(beside, questions, about))


def _trials(trials: TrialFile, how: Anonymising, content: bytes) -> bytes:
    header = msgspec.structs.replace(
        trials.header,
        participant=how.code(trials.header.participant),
        created_utc=NO_DATE if "dates" in how.removed else trials.header.created_utc,
        facts=how.facts(trials.header.facts) | how.about(content),
    )
    records = [msgspec.structs.replace(each, comment=_remark(each.comment, how)) for each in trials.trials]
    return b"".join(msgspec.json.encode(line) + b"\n" for line in (header, *records))


def _remark(comment: str, how: Anonymising) -> str:
    """Return the program's remark on a trial without how the terminal was reached."""
    return re.sub(r"resumed \([^)]*\)", "resumed", comment) if "terminal" in how.removed else comment


@dataclass(frozen=True, slots=True)
class _Sitting:
    """What copying a record of a sitting needs."""

    names: Mapping[str, str]
    questions: Mapping[str, QuestionList]
    about: Mapping[str, str]


def _sitting(
    header: SittingHeader, lines: tuple[SittingLine, ...], how: Anonymising, context: _Sitting
) -> bytes:
    changed: list[SittingLine] = [
        msgspec.structs.replace(
            header,
            participant=how.code(header.participant),
            at_utc=_date(header.at_utc, how),
            software=header.software | dict(context.about),
        )
    ]
    for line in lines:
        match line:
            case ConsentAnswered() | SittingClosed():
                line = msgspec.structs.replace(line, at_utc=_date(line.at_utc, how))
            case FileRecorded():
                line = msgspec.structs.replace(line, file=context.names.get(line.file, NO_TEXT))
            case QuestionAnswered() if "free-text" in how.removed and _is_typed(line, context.questions):
                line = msgspec.structs.replace(line, answer=NO_TEXT)
            case _:
                pass
        changed.append(line)
    chain = Chain()
    return b"".join(chain.seal(msgspec.json.encode(line)) for line in changed)


def _date(text: str, how: Anonymising) -> str:
    return NO_DATE if "dates" in how.removed else text


def _is_typed(line: QuestionAnswered, questions: Mapping[str, QuestionList]) -> bool:
    """Return whether an answer is the participant's own words, or might be: its question is not known."""
    known: dict[str, Any] = {
        question.id: question
        for name, asked in questions.items()
        if line.questionnaire in (name, asked.name)
        for question in asked.questions
    }
    question = known.get(line.question)
    if question is None:
        return isinstance(line.answer, str | tuple)
    return isinstance(question, FreeText) and line.answer is not None
