"""Read a study file with all that it names: texts, questionnaires, and the protocol of every condition."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import msgspec

from core.configuration.reading import ConfigurationError, Problem, filled, read_whole
from core.configuration.toml_places import places
from core.feedback.delays import GammaDelay
from core.session.practice import practice_of
from core.session.protocol import Language, Protocol
from core.session.protocol_file import LARGEST_BYTES, ProtocolError, located, read_toml
from core.session.protocol_reading import protocol_from
from core.system.bounded_read import EndlessFileError
from studies.lab.config import Block, Break, Consent, Debriefing, Practice, Questionnaire, Study, TextPage
from studies.lab.questions import QuestionList, QuestionsError, read_questions

HELP = "docs/study.md (`arl study settings`) has every key with what it means."


class StudyError(ValueError):
    """A study cannot be used; each line of the message says where, what is wrong, and what to do."""


@dataclass(frozen=True, slots=True)
class LoadedStudy:
    """A study with everything that its file names."""

    path: Path
    study: Study
    sha256: str
    """Of the file's bytes, hex."""
    texts: Mapping[str, str]
    """Markdown by file name."""
    questionnaires: Mapping[str, QuestionList]
    """By the name that steps use."""
    protocols: Mapping[str, Protocol]
    """By condition."""

    @property
    def theme(self) -> str:
        """Theme of the study's pages: that of its first condition's protocol."""
        return next(iter(self.protocols.values())).screen.theme

    def block_protocol(self, condition: str, step: Block) -> Protocol:
        """Return the protocol of a block. Its name is the study's, so that it says nothing about the
        condition.
        """
        protocol = self.protocols[condition]
        session = protocol.session
        if step.games is not None:
            session = msgspec.structs.replace(session, episodes=step.games)
        return msgspec.structs.replace(protocol, name=self.study.name, session=session)

    def practice_protocol(self, step: Practice) -> Protocol:
        """Return the protocol of a practice: slow, nothing unseen, no wrong presses; it says nothing about a
        condition.
        """
        protocol = next(iter(self.protocols.values()))
        return practice_of(protocol, games=step.games, name=self.study.name)

    def simulated_protocol(self, condition: str, step: Block) -> Protocol:
        """Return the protocol of a block for a simulated participant, whose own delay is known without a
        calibration.
        """
        protocol = self.block_protocol(condition, step)
        if protocol.delay_of == "rule":
            return protocol
        own = GammaDelay() if protocol.delay_of == "paper" else protocol.trainer.delay
        credit = msgspec.structs.replace(protocol.agent.credit, delay=own)
        agent = msgspec.structs.replace(protocol.agent, credit=credit)
        return msgspec.structs.replace(protocol, agent=agent, delay_of="rule")


def load_study(path: Path) -> LoadedStudy:
    """Read a study file and everything beside it.

    Raises:
        StudyError: something is missing or wrong; all that is found is named, a line each.
        OSError: the file cannot be read.
    """
    try:
        text, plain = read_toml(path, what="a study", advice=HELP)
        study = read_whole(plain, Study)
    except ProtocolError as error:
        raise StudyError(str(error)) from error
    except ConfigurationError as error:
        raise StudyError(located(path, text, error.problems, advice=HELP)) from error
    trouble: list[str] = []
    texts = _texts(study, path.parent, trouble)
    questionnaires = _questionnaires(study, path.parent, trouble)
    protocols = _protocols(study, path, text, trouble)
    if trouble:
        raise StudyError("\n".join(trouble))
    sha256 = hashlib.sha256(path.read_bytes()).hexdigest()
    return LoadedStudy(path, study, sha256, texts, questionnaires, protocols)


def combined(base: Mapping[str, Any], differences: Mapping[str, Any]) -> dict[str, Any]:
    """Return the base with the differences written over it, table by table.

    A table that names another `type` than the base's replaces the base's table as a whole.
    """
    return filled(differences, base)


def _texts(study: Study, folder: Path, trouble: list[str]) -> dict[str, str]:
    texts: dict[str, str] = {}
    for sitting, place, step in study.steps:
        if isinstance(step, Consent | TextPage | Debriefing | Break) and step.text:
            try:
                texts[step.text] = _page(folder / step.text)
            except (OSError, ValueError) as error:
                trouble.append(
                    f"{folder / step.text}: needed by step {place + 1} of sitting {sitting + 1}: "
                    f"{_reason(error)}"
                )
    return texts


def _page(path: Path) -> str:
    if path.exists() and not path.is_file() and not path.is_dir():
        raise EndlessFileError(
            path, "a pipe or a device, not a file"
        )  # opening a pipe would wait for a writer
    with path.open(encoding="utf-8-sig") as file:
        text = file.read(LARGEST_BYTES + 1)
    if len(text) > LARGEST_BYTES:
        raise ValueError(f"a page has at most {LARGEST_BYTES} characters, this file has more")
    return text


def _questionnaires(study: Study, folder: Path, trouble: list[str]) -> dict[str, QuestionList]:
    found: dict[str, QuestionList] = {}
    for _, _, step in study.steps:
        if isinstance(step, Questionnaire) and step.questions not in found:
            try:
                found[step.questions] = read_questions(step.questions, folder, study.language)
            except QuestionsError as error:
                trouble.append(str(error))
    return found


def _protocols(study: Study, path: Path, text: str, trouble: list[str]) -> dict[str, Protocol]:
    base: Mapping[str, Any] = study.protocol
    base_path, base_text = path, text
    above: tuple[str, ...] = ("protocol",)
    if study.protocol_file:
        base_path, above = path.parent / study.protocol_file, ()
        try:
            base_text, base = read_toml(base_path)
        except (OSError, ValueError) as error:
            trouble.append(f"{base_path}: {_reason(error)}" if isinstance(error, OSError) else str(error))
            return {}
    protocols: dict[str, Protocol] = {}
    in_base: dict[str, tuple[Problem, list[str]]] = {}
    found = places(text)
    for name, differences in study.conditions.items():
        try:
            protocols[name] = _in_language(
                protocol_from(combined(base, differences), to_run=True), study.language
            )
        except ConfigurationError as error:
            for problem in error.problems:
                here = ("conditions", name, *problem.path)
                if here in found:
                    trouble.append(located(path, text, [replace(problem, path=here)], advice=""))
                else:  # not among the differences: the base says it
                    in_base.setdefault(str(problem), (replace(problem, path=(*above, *problem.path)), []))[
                        1
                    ].append(name)
    for problem, names in in_base.values():
        said = "" if len(names) == len(study.conditions) else f" (in the condition {', '.join(names)})"
        problem = replace(problem, reason=problem.reason + said)
        trouble.append(located(base_path, base_text, [problem], advice=""))
    games = {protocol.game for protocol in protocols.values()}
    if len(games) > 1:
        trouble.append(f"{path}: the conditions are about different games: {', '.join(sorted(games))}")
    return protocols


def _in_language(protocol: Protocol, language: Language) -> Protocol:
    """Return a protocol whose screens are in the language of the study.

    Raises:
        ConfigurationError: it names another one itself.
    """
    if protocol.screen.language not in ("en", language):
        reason = "a study has one language for all its pages: write it as `language` at the top of the file"
        raise ConfigurationError([Problem(("screen", "language"), reason, protocol.screen.language)])
    screen = msgspec.structs.replace(protocol.screen, language=language)
    return msgspec.structs.replace(protocol, screen=screen)


def _reason(error: Exception) -> str:
    if isinstance(error, FileNotFoundError):
        return "there is no such file"
    if isinstance(error, UnicodeDecodeError):
        byte = error.object[error.start]
        return f"the byte 0x{byte:02x} is none of UTF-8: save the page as UTF-8 in your editor"
    return error.strerror or str(error) if isinstance(error, OSError) else str(error)
