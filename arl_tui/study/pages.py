"""Pages of a study: text, consent, break, thanks. Keyboard only; every page can be left."""

from collections.abc import Iterable, Sequence
from typing import ClassVar

from textual import events
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.screen import ModalScreen, Screen
from textual.widget import Widget
from textual.widgets import Markdown, Static

from arl_tui.app.key_help import HELP
from arl_tui.language import cap, key_for, later, tr
from arl_tui.study import words
from core.numerics.clock import Clock, seconds

STOP_KEYS = "q,ctrl+q,ctrl+c"


class StudyPage(Screen[object], inherit_bindings=False):
    """A page with a heading, something to read, and a last line that says which keys work.

    It is dismissed with its result. `Stop` is posted where the participant wants to leave the study.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding(STOP_KEYS, "stop", "Stop", id="study.stop", tooltip="Stop the study"),
        Binding("down", "scroll(1)", "Down", id="study.down", show=False),
        Binding("up", "scroll(-1)", "Up", id="study.up", show=False),
        Binding("pagedown,space", "scroll_page(1)", "Page down", id="study.pagedown", show=False),
        Binding("pageup", "scroll_page(-1)", "Page up", id="study.pageup", show=False),
        Binding("enter", "go_on", "Go on", id="study.go-on", tooltip="Go on"),
    ]

    def __init__(self, heading: str, *, code: str, part: str = "") -> None:
        """Prepare a page.

        Args:
            heading: above the text.
            code: of the participant, for the page that asks whether to stop.
            part: where in the sitting this is, in words.
        """
        super().__init__()
        self._heading = heading
        self._code = code
        self._part = part
        self._left = False

    def compose(self) -> ComposeResult:
        """Lay out heading, text and the line of keys."""
        with VerticalScroll(classes="page study", can_focus=False):
            if self._heading:
                yield Static(self._heading, classes="title")
            yield from self.contents()
        with Vertical(id="foot"):
            yield Static(id="call", classes="call")
            yield Static(self._part, classes="part")

    @property
    def reading(self) -> str:
        """What is read on this page, Markdown; empty where it has no text of its own."""
        return ""

    def contents(self) -> Iterable[Widget]:
        """Return what is read on this page."""
        raise NotImplementedError

    def call(self) -> str:
        """Return the line that says which keys work, in markup."""
        verb = tr(words.GO_ON) if self.at_end else tr(words.READ_ON)
        return f"{verb}, {tr(words.STOP)}"

    @property
    def at_end(self) -> bool:
        """Whether the last line of the text is on screen."""
        scroll = self.query_one(VerticalScroll)
        return scroll.max_scroll_y <= 0 or scroll.scroll_target_y >= scroll.max_scroll_y

    def on_mount(self) -> None:
        """Say which keys work, when the size of the text is known."""
        self.call_after_refresh(self.show_call)
        # Markdown is laid out in a task of its own: its size is known a moment later.
        self.set_interval(0.2, self.show_call)

    def show_call(self) -> None:
        """Write the line of keys anew."""
        if self.is_mounted and self.query("#call"):
            self.query_one("#call", Static).update(self.call())

    def finish(self, result: object) -> None:
        """Leave the page once, however often it is asked to."""
        if not self._left:
            self._left = True
            self.dismiss(result)

    def action_scroll(self, lines: int) -> None:
        """Move the text by lines."""
        self.query_one(VerticalScroll).scroll_relative(y=lines, animate=False)
        self.call_after_refresh(self.show_call)

    def action_scroll_page(self, pages: int) -> None:
        """Move the text by pages, a line less than what is on screen."""
        scroll = self.query_one(VerticalScroll)
        scroll.scroll_relative(y=pages * max(1, scroll.size.height - 1), animate=False)
        self.call_after_refresh(self.show_call)

    def action_go_on(self) -> None:
        """Read on, or leave the page where all of it has been on screen."""
        if self.at_end:
            self.done()
        else:
            self.action_scroll_page(1)

    def done(self) -> None:
        """Leave the page: the participant goes on."""
        self.finish(True)

    def action_stop(self) -> None:
        """Ask whether the participant wants to stop."""
        self.app.push_screen(StopPage(self._code), self._stop_answered)

    def _stop_answered(self, yes: object) -> None:
        if yes:
            self.finish(None)


class StopPage(ModalScreen[bool], inherit_bindings=False):
    """Asks whether to stop, and says what happens to the data."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("y", "answer(True)", "Stop", id="study-stop.yes", tooltip="Stop the study"),
        Binding("n,escape,enter", "answer(False)", "Go on", id="study-stop.no", tooltip="Go on"),
        HELP,
    ]

    def __init__(self, code: str) -> None:
        super().__init__()
        self._code = code

    def compose(self) -> ComposeResult:
        """Lay out the question."""
        with VerticalScroll(classes="page", can_focus=False):
            yield Static(tr(words.STOP_HEADING), classes="title")
            yield Static(tr(words.STOP_TEXT, code=self._code))

    def action_answer(self, yes: bool) -> None:
        """Leave with the answer."""
        self.dismiss(yes)

    async def action_page_help(self) -> None:
        """Say what the keys of this page do: the app's own binding does not reach a modal page."""
        await self.app.run_action("page_help")


class TextPage(StudyPage):
    """A text of the study. The result is True."""

    def __init__(self, text: str, *, code: str, part: str = "", heading: str = "") -> None:
        super().__init__(heading, code=code, part=part)
        self._text = text

    @property
    def reading(self) -> str:
        """The text."""
        return self._text

    def contents(self) -> Iterable[Widget]:
        """Return the text."""
        yield Markdown(self._text, open_links=False)


class ConsentPage(StudyPage):
    """The text, then its statements. The result is a dict of statement to answer, or False if the participant
    declines.
    """

    MORE_KEYS = (("↑ ↓", later("Go to another statement")),)
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("y", "answer(True)", "Yes", id="consent.yes", tooltip="Agree to the statement"),
        Binding("n", "answer(False)", "No", id="consent.no", tooltip="Do not agree to the statement"),
    ]

    def __init__(
        self, text: str, statements: Sequence[str], optional: Sequence[str], *, code: str, part: str = ""
    ) -> None:
        """Prepare the page.

        Args:
            text: of the consent, Markdown.
            statements: each must be agreed to.
            optional: each may be declined.
            code: of the participant.
            part: where in the sitting this is, in words.
        """
        super().__init__(tr(words.CONSENT), code=code, part=part)
        self._text = text
        self.n_statements = len(statements) + len(optional)
        self._statements = [*statements, *optional]
        self._required = len(statements)
        self._answers: list[bool | None] = [None] * len(self._statements)
        self._at = 0
        self._remark = ""

    @property
    def reading(self) -> str:
        """The text."""
        return self._text

    def contents(self) -> Iterable[Widget]:
        """Return text and statements."""
        yield Markdown(self._text, open_links=False)
        yield Static(tr(words.CONSENT_HELP))
        for number in range(len(self._statements)):
            with Horizontal(classes="statement"):
                yield Static(self._answer(number), id=f"answer-{number}", classes="answer")
                yield Static(_plain(self._statements[number]), classes="words")

    def call(self) -> str:
        """Return what is missing, or which keys work."""
        return self._remark or super().call()

    def on_key(self, event: events.Key) -> None:
        """Move between statements with the arrow keys once the text has been read."""
        if event.key in ("up", "down") and self.at_end:
            event.stop()
            event.prevent_default()
            self._move(1 if event.key == "down" else -1)

    def action_scroll(self, lines: int) -> None:
        """Move between statements at the end of the text, else move the text."""
        if self.at_end and not (lines < 0 and self._at == 0):
            self._move(lines)
        else:
            super().action_scroll(lines)

    def action_answer(self, yes: bool) -> None:
        """Answer the marked statement, and go to the next one."""
        if not self.at_end:
            return  # nobody answers what has not been on screen
        self._answers[self._at] = yes
        self._remark = ""
        self._move(1)
        self.show_call()

    def done(self) -> None:
        """Leave with the answers, if each statement has one."""
        if None in self._answers:
            self._remark = tr(words.CONSENT_OPEN)
            self._at = self._answers.index(None)
            self._move(0)
            self.show_call()
        elif all(self._answers[: self._required]):
            self.finish(dict(zip(self._statements, self._answers, strict=True)))
        else:
            self._remark = tr(words.CONSENT_NEEDED)
            self.show_call()
            self.app.push_screen(DeclinePage(), self._declined)

    def _declined(self, yes: object) -> None:
        if yes:
            self.finish(False)

    def _move(self, by: int) -> None:
        self._at = min(max(self._at + by, 0), len(self._statements) - 1)
        for number in range(len(self._statements)):
            self.query_one(f"#answer-{number}", Static).update(self._answer(number))

    def _answer(self, number: int) -> str:
        answer = {None: "[reverse]   [/]", True: cap(key_for("yes")), False: cap(key_for("no"))}[
            self._answers[number]
        ]
        mark = ">" if number == self._at else " "
        required = "*" if number < self._required else " "
        return f"{mark} {answer} {required}"


class DeclinePage(ModalScreen[bool], inherit_bindings=False):
    """Confirms that the participant does not want to take part."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("enter", "answer(True)", "Leave", id="decline.yes", tooltip="Leave; nothing is kept"),
        Binding("b,escape", "answer(False)", "Back", id="decline.no", tooltip="Go back to the statements"),
        HELP,
    ]

    def compose(self) -> ComposeResult:
        """Lay out the question."""
        with VerticalScroll(classes="page", can_focus=False):
            yield Static(tr(words.DECLINE_HEADING), classes="title")
            yield Static(tr(words.DECLINE))

    def action_answer(self, yes: bool) -> None:
        """Leave with the answer."""
        self.dismiss(yes)

    async def action_page_help(self) -> None:
        """Say what the keys of this page do: the app's own binding does not reach a modal page."""
        await self.app.run_action("page_help")


class BreakPage(StudyPage):
    """A rest. The participant cannot go on before its shortest time. The result is True."""

    def __init__(
        self,
        text: str,
        *,
        shortest_s: float,
        longest_s: float,
        code: str,
        clock: Clock,
        part: str = "",
    ) -> None:
        """Prepare the page.

        Args:
            text: Markdown.
            shortest_s: the participant cannot go on before, seconds.
            longest_s: the participant is asked to come back after, seconds.
            clock: by which the break is measured.
            code: of the participant.
            part: where in the sitting this is, in words.
        """
        super().__init__(tr(words.BREAK_HEADING), code=code, part=part)
        self._text = text
        self.shortest_s = shortest_s
        self._longest_s = longest_s
        self._clock = clock
        self._since_ns = clock.now_ns()

    @property
    def reading(self) -> str:
        """The text."""
        return self._text

    def contents(self) -> Iterable[Widget]:
        """Return the text."""
        yield Markdown(self._text or tr(words.BREAK_TEXT), open_links=False)

    @property
    def waited_s(self) -> float:
        """How long the break has been, seconds."""
        return seconds(self._clock.now_ns() - self._since_ns)

    def call(self) -> str:
        """Return how long the break still is, or that it is over."""
        left = self.shortest_s - self.waited_s
        if left > 0:
            return tr(words.BREAK_WAIT, seconds=int(left) + 1)
        return tr(words.BREAK_OVER) if self.waited_s > self._longest_s else super().call()

    def done(self) -> None:
        """Leave the page, not before the shortest time."""
        if self.waited_s >= self.shortest_s:
            super().done()


class NoticePage(StudyPage):
    """The last page: thanks, one's own numbers, the code. The result is True."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding(STOP_KEYS, "go_on", "Leave", id="notice.leave", tooltip="Leave"),
    ]

    def __init__(self, heading: str, text: str, remarks: Sequence[str], *, code: str) -> None:
        """Prepare the page.

        Args:
            heading: above the text.
            text: Markdown.
            remarks: below the text, in markup.
            code: of the participant.
        """
        super().__init__(heading, code=code)
        self._text = text
        self._remarks = remarks

    @property
    def reading(self) -> str:
        """The text."""
        return self._text

    def contents(self) -> Iterable[Widget]:
        """Return text and remarks."""
        if self._text:
            yield Markdown(self._text, open_links=False)
        for remark in self._remarks:
            yield Static(remark, classes="remark")

    def call(self) -> str:
        """Return how to leave."""
        return tr(words.LEAVE) if self.at_end else tr(words.READ_ON)


def _plain(text: str) -> str:
    """Return a text of the study as markup that shows it as it is."""
    return text.replace("\\", "\\\\").replace("[", "\\[")
