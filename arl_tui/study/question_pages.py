"""A page for each kind of question. The result is an answer with its times, or None if the participant
stops.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import ClassVar, assert_never

from textual import events
from textual.binding import Binding, BindingType
from textual.widget import Widget
from textual.widgets import Input, Static

from arl_tui.language import later, tr
from arl_tui.study import words
from arl_tui.study.pages import StudyPage, _plain
from core.numerics.clock import Clock
from studies.lab.questions import Answer, Choice, FreeText, Likert, Number, Press, Question, Scale, refusal

SCALE_CELLS = 51
"""Places of the mark of a visual analogue scale on screen."""


def _end(text: str) -> str:
    """Return an end of a Likert row: of the study, or ours, in the language in use."""
    return tr(text) if text in words.ENDS_OF_A_LIKERT_ROW else text


@dataclass(frozen=True, slots=True)
class Answered:
    """A confirmed answer."""

    answer: Answer
    shown_ns: int
    answered_ns: int


class QuestionPage(StudyPage):
    """One question. Digits, arrows and Enter; or a line to type in."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("ctrl+n", "skip", "Leave out", id="question.skip", tooltip="Go on without an answer"),
    ]

    def __init__(self, question: Question, *, number: int, count: int, code: str, clock: Clock) -> None:
        """Prepare the page.

        Args:
            question: what is asked.
            number: of the question, from 1.
            count: how many there are.
            code: of the participant.
            clock: of the answer's times.
        """
        super().__init__("", code=code, part=tr(words.PROGRESS, number=number, count=count))
        self.question = question
        self._clock = clock
        self._shown_ns = clock.now_ns()
        self._remark = ""
        self._at = 0 if isinstance(question, Choice) else None
        if isinstance(question, Scale):
            self._at = question.maximum // 2
        self._touched = False
        self._chosen: set[int] = set()

    @property
    def MORE_KEYS(self) -> tuple[tuple[str, str], ...]:
        """Keys of the question, with English words (`arl_tui.app.key_help`)."""
        match self.question:
            case Likert() | Choice(several=False):
                return (("1-9", later("Choose an answer")), ("← → ↑ ↓", later("Choose an answer")))
            case Choice():
                return (("1-9", later("Choose, or no longer")), ("↑ ↓", later("Go to another answer")))
            case Scale():
                return (("← →", later("Move the mark")),)
            case _:
                return ()

    # --- what is shown --------------------------------------------------------------------------------------

    def contents(self) -> Iterable[Widget]:
        """Return the question and what can be chosen."""
        yield Static(f"[b]{_plain(self.question.text)}[/]", classes="question")
        if isinstance(self.question, Number | FreeText):
            yield Input(id="typed", type="number" if isinstance(self.question, Number) else "text")
            if isinstance(self.question, Number) and self.question.unit:
                yield Static(_plain(self.question.unit))
        elif not isinstance(self.question, Press):
            yield Static(self._drawn(), id="answers")
        if not self.question.required:
            yield Static(f"[dim]{tr(words.MAY_SKIP)}[/]", classes="hint")

    def call(self) -> str:
        """Return how to answer, or what is wrong with the answer."""
        if self._remark:
            return f"[$text-error]{_plain(self._remark)}[/]"
        match self.question:
            case Likert():
                return tr(words.ANSWER_LIKERT)
            case Scale():
                return tr(words.ANSWER_SCALE)
            case Choice(several=several):
                return tr(words.ANSWER_SEVERAL) if several else tr(words.ANSWER_CHOICE)
            case Number() | FreeText():
                return tr(words.ANSWER_TYPED)
            case Press():
                return tr(words.ANSWER_PRESS)
            case other:
                assert_never(other)

    def on_mount(self) -> None:
        """Let typed answers be typed at once."""
        super().on_mount()
        for line in self.query(Input):
            line.focus()

    def _drawn(self) -> str:
        match self.question:
            case Likert(points=points, low=low, high=high):
                marks = "   ".join(
                    f"[reverse b] {k} [/]" if k == self._at else f" {k} " for k in range(1, points + 1)
                )
                return f"{marks}\n\n1 = {_plain(_end(low))}, {points} = {_plain(_end(high))}\n"
            case Scale(maximum=maximum, low=low, high=high):
                cell = round((self._at or 0) / maximum * (SCALE_CELLS - 1))
                line = "".join("█" if k == cell and self._touched else "─" for k in range(SCALE_CELLS))
                gap = " " * max(1, SCALE_CELLS - len(low) - len(high))
                return f"|{line}|\n {_plain(low)}{gap}{_plain(high)}\n"
            case Choice(options=options, several=several):
                return "\n".join(self._option(k, text, several) for k, text in enumerate(options))
            case _:
                return ""

    def _option(self, number: int, text: str, several: bool) -> str:
        chosen = number in self._chosen if several else number == self._at and self._touched
        mark = "x" if chosen else " "
        cursor = ">" if number == self._at else " "
        return f"{cursor} {number + 1}  \\[{mark}] {_plain(text)}"

    def _draw(self) -> None:
        self._remark = ""
        self.query_one("#answers", Static).update(self._drawn())
        self.show_call()

    # --- keys -----------------------------------------------------------------------------------------------

    def on_key(self, event: events.Key) -> None:
        """Choose with digits, arrows and Space; the first letter or digit answers an instructed press."""
        if isinstance(self.question, Press):
            key = event.key.lower()
            if len(key) == 1 and key.isalnum() and key != "q":
                event.stop()
                event.prevent_default()
                self._leave_with(key)
            return
        if isinstance(self.question, Number | FreeText):
            return
        by = {"left": -1, "up": -1, "right": 1, "down": 1}.get(event.key)
        if by is not None:
            self._step(
                -by if isinstance(self.question, Likert | Scale) and event.key in ("up", "down") else by
            )
        elif event.key.isdigit() and not isinstance(self.question, Scale):
            self._take_digit(int(event.key))
        elif event.key == "space" and isinstance(self.question, Choice):
            self._toggle()
        else:
            return
        event.stop()
        event.prevent_default()
        self._draw()

    def action_scroll(self, lines: int) -> None:
        """Arrow keys choose an answer here."""

    def _step(self, by: int) -> None:
        match self.question:
            case Likert(points=points):
                self._at = min(
                    max((self._at if self._at is not None else (points + 1) // 2 - by) + by, 1), points
                )
            case Scale(maximum=maximum, step=step):
                moved = (self._at or 0) + by * max(step, round(maximum / (SCALE_CELLS - 1)))
                self._at = min(max(moved, 0), maximum)
            case Choice(options=options):
                self._at = ((self._at or 0) + by) % len(options)
        self._touched = True

    def _take_digit(self, digit: int) -> None:
        match self.question:
            case Likert(points=points) if 1 <= digit <= points:
                self._at = digit
                self._touched = True
            case Choice(options=options, several=several) if 1 <= digit <= len(options):
                self._at = digit - 1
                self._touched = True
                if several:
                    self._toggle()

    def _toggle(self) -> None:
        if self._at is not None:
            self._chosen ^= {self._at}
            self._touched = True

    def on_input_submitted(self, event: Input.Submitted) -> None:
        """Confirm a typed answer."""
        event.stop()
        self.done()

    # --- the answer -----------------------------------------------------------------------------------------

    def answer(self) -> Answer:
        """Return the answer as it stands; None if there is none yet."""
        match self.question:
            case Number():
                typed = self.query_one(Input).value.strip().replace(",", ".")
                try:
                    return float(typed) if typed else None
                except ValueError:
                    return typed
            case Press():
                return None  # answered by the press itself, not by Enter
            case FreeText():
                return self.query_one(Input).value.strip() or None
            case Choice(options=options, several=True):
                return tuple(options[k] for k in sorted(self._chosen)) or None
            case Choice(options=options):
                return options[self._at or 0] if self._touched else None
            case Likert() | Scale():
                return self._at if self._touched else None
            case other:
                assert_never(other)

    def done(self) -> None:
        """Leave with the answer if it is allowed; else say why not."""
        answer = self.answer()
        reason = refusal(self.question, answer)
        if reason is None:
            self._leave_with(answer)
        else:
            self._remark = tr(reason.text, **reason.values)
            self.show_call()

    def action_skip(self) -> None:
        """Leave without an answer where that is allowed."""
        if not self.question.required:
            self._leave_with(None)

    def _leave_with(self, answer: Answer) -> None:
        self.finish(Answered(answer, self._shown_ns, self._clock.now_ns()))
