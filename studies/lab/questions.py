"""Questionnaires: what can be asked, which answers are allowed, and the ready ones. No screen."""

from collections.abc import Mapping
from importlib import resources
from pathlib import Path
from types import MappingProxyType
from typing import Annotated, Literal, NamedTuple, assert_never

from msgspec import Meta

from core.configuration.fields import ALLOWED
from core.configuration.reading import ConfigurationError, read_whole
from core.session.protocol import Language
from core.session.protocol_file import ProtocolError, located, read_toml
from studies.lab.config import Code, Table

READY = ("demographics", "nasa-tlx", "sus", "trust", "taught")
"""Names of the questionnaires that come with the program."""
Answer = int | float | str | tuple[str, ...] | None
"""None: the participant preferred not to answer."""


class Item(Table, frozen=True, kw_only=True):
    """What all questions have."""

    id: Code
    """Names the answer in tables."""
    text: str
    """The question, or the statement that is judged."""
    required: bool = True
    """False: the participant may go on without an answer."""


class Likert(Item, frozen=True, kw_only=True, tag="likert"):
    """A statement and a row of points from disagreement to agreement."""

    points: Annotated[int, Meta(ge=2, le=11)] = 5
    """How many points the row has."""
    low: str = "strongly disagree"
    """Stands at the left end."""
    high: str = "strongly agree"
    """Stands at the right end."""
    correct: int | None = None
    """The answer of an attention check, 1 to `points`; None: every answer is right."""

    def __post_init__(self) -> None:
        if self.correct is not None and not 1 <= self.correct <= self.points:
            raise ValueError(f"correct is 1..{self.points}, got {self.correct}")


class Scale(Item, frozen=True, kw_only=True, tag="scale"):
    """A visual analogue scale between two words."""

    low: str
    """Stands at the left end."""
    high: str
    """Stands at the right end."""
    maximum: Annotated[int, Meta(ge=2, le=1000)] = 100
    """The right end; the left end is 0."""
    step: Annotated[int, Meta(ge=1, le=100)] = 1
    """Distance between two positions of the mark."""


class Choice(Item, frozen=True, kw_only=True, tag="choice"):
    """One of several options, or several of them."""

    options: tuple[str, ...]
    """What can be chosen, two or more."""
    several: bool = False
    """More than one option may be chosen."""
    correct: str | None = None
    """The answer of an attention check; None: every answer is right."""

    def __post_init__(self) -> None:
        if len(set(self.options)) != len(self.options) or len(self.options) < 2:
            raise ValueError(f"options are two or more different texts, got {list(self.options)}")
        if self.correct is not None and self.correct not in self.options:
            raise ValueError(f"correct is one of the options, got {self.correct!r}")


class Number(Item, frozen=True, kw_only=True, tag="number"):
    """A number within bounds."""

    lowest: float = 0.0
    """Smallest number that is taken."""
    highest: float = 1000.0
    """Largest number that is taken."""
    unit: str = ""
    """Stands behind the number."""

    def __post_init__(self) -> None:
        if not self.lowest < self.highest:
            raise ValueError(f"lowest is below highest, got {self.lowest:g} and {self.highest:g}")


class FreeText(Item, frozen=True, kw_only=True, tag="text"):
    """Words of the participant's own."""

    longest: Annotated[int, Meta(ge=1, le=10_000)] = 1000
    """Characters at most."""


class Press(Item, frozen=True, kw_only=True, tag="press"):
    """An instructed press: an attention check that is passed with one named key."""

    key: Annotated[
        str, Meta(pattern="^[a-pr-z0-9]$", extra={ALLOWED: "one small letter but q, or one digit"})
    ]
    """The key that is asked for; the text names it, too. The first letter or digit that is pressed counts."""


Question = Likert | Scale | Choice | Number | FreeText | Press


class QuestionList(Table, frozen=True, kw_only=True):
    """A questionnaire."""

    name: Code
    """Names the questionnaire in tables."""
    title: str = ""
    """Above the introduction; participants see it."""
    introduction: str = ""
    """Shown on a page of its own before the first question, Markdown."""
    source: str = ""
    """Where the questions come from."""
    scoring: Literal["", "sus", "nasa-tlx-raw"] = ""
    """How a total is worked out in tables; empty: no total."""
    questions: tuple[Question, ...]

    def __post_init__(self) -> None:
        names = [question.id for question in self.questions]
        twice = {name for name in names if names.count(name) > 1}
        if twice or not names:
            raise ValueError(
                f"every question has an id of its own; twice: {sorted(twice)}" if names else "no questions"
            )


class QuestionsError(ValueError):
    """A questionnaire cannot be used; the message says where and why."""


def read_questions(name: str, folder: Path, language: Language = "en") -> QuestionList:
    """Return a ready questionnaire, or the one in a TOML file.

    Args:
        name: one of `READY`, or a file in `folder`.
        folder: of the study file.
        language: of a ready questionnaire.

    Raises:
        QuestionsError: the file is not there, is not TOML, or holds what is not a questionnaire.
    """
    if name in READY:
        ready = resources.files(__package__) / "questionnaires"
        with resources.as_file((ready if language == "en" else ready / language) / f"{name}.toml") as path:
            return _read(path)
    try:
        return _read(folder / name)
    except FileNotFoundError as error:
        raise QuestionsError(
            f"{folder / name}: there is no such file; name a TOML file beside the study file, or one of "
            f"{', '.join(READY)}"
        ) from error
    except OSError as error:
        raise QuestionsError(f"{folder / name}: {error}") from error


def _read(path: Path) -> QuestionList:
    advice = "docs/study.md has every key of a questionnaire."
    try:
        text, plain = read_toml(path, what="a questionnaire", advice=advice)
        return read_whole(plain, QuestionList)
    except ProtocolError as error:
        raise QuestionsError(str(error)) from error
    except ConfigurationError as error:
        raise QuestionsError(located(path, text, error.problems, advice="")) from error


class Refusal(NamedTuple):
    """Why an answer is not allowed: a sentence for the participant."""

    text: str
    """English, with placeholders; the app has it in other languages."""
    values: Mapping[str, object] = MappingProxyType({})
    """By the names of the placeholders."""

    def __str__(self) -> str:
        """Return the sentence in English."""
        return self.text.format(**self.values)


def refusal(question: Question, answer: Answer) -> Refusal | None:
    """Return why an answer is not allowed; None if it is."""
    if answer is None or answer in ("", ()):
        return Refusal("Please answer this question.") if question.required else None
    match question:
        case Likert(points=points):
            allowed = isinstance(answer, int) and 1 <= answer <= points
            return (
                None if allowed else Refusal("Please choose a number from 1 to {points}.", {"points": points})
            )
        case Scale(maximum=maximum):
            allowed = isinstance(answer, int | float) and 0 <= answer <= maximum
            return (
                None
                if allowed
                else Refusal("Please choose a place from 0 to {maximum}.", {"maximum": maximum})
            )
        case Choice(options=options, several=several):
            chosen = answer if isinstance(answer, tuple) else (answer,)
            if not several and len(chosen) > 1:
                return Refusal("Please choose one answer.")
            return None if set(chosen) <= set(options) else Refusal("Please choose from the list.")
        case Number(lowest=lowest, highest=highest, unit=unit):
            allowed = isinstance(answer, int | float) and lowest <= answer <= highest
            if allowed:
                return None
            limits = {"lowest": f"{lowest:g}", "highest": f"{highest:g} {unit}".rstrip()}
            return Refusal("Please type a number from {lowest} to {highest}.", limits)
        case Press():
            pressed = isinstance(answer, str) and len(answer) == 1
            return None if pressed else Refusal("Please press one key.")
        case FreeText(longest=longest):
            too_long = len(str(answer)) > longest
            return (
                Refusal("Please use at most {longest} characters.", {"longest": longest})
                if too_long
                else None
            )
        case other:
            assert_never(other)


def passed(question: Question, answer: Answer) -> bool | None:
    """Return whether an attention check was passed; None where the question is none."""
    if isinstance(question, Press):
        return answer == question.key
    if isinstance(question, Likert | Choice) and question.correct is not None:
        return answer == question.correct or answer == (question.correct,)
    return None


def total(questions: QuestionList, answers: dict[str, Answer]) -> float | None:
    """Return the questionnaire's total; None where it has none, or an answer is missing.

    SUS: 0 to 100 (Brooke 1996): odd statements count answer - 1, even ones 5 - answer, times 2.5. Raw
    NASA-TLX: the mean of the six scales, 0 to 100 (Hart 2006).
    """
    values = [answers.get(question.id) for question in questions.questions]
    numbers = [float(value) for value in values if isinstance(value, int | float)]
    if not questions.scoring or len(numbers) != len(values):
        return None
    if questions.scoring == "nasa-tlx-raw":
        return sum(numbers) / len(numbers)
    return 2.5 * sum(value - 1 if number % 2 == 0 else 5 - value for number, value in enumerate(numbers))
