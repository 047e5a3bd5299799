"""Everything a participant reads between trials."""

from collections.abc import Iterable, Sequence
from typing import ClassVar

from rich.text import Text
from textual.binding import Binding, BindingType
from textual.widget import Widget
from textual.widgets import Static

from arl_tui.calibration.fitting import Fitted
from arl_tui.calibration.plan import Part, Unfinished, minutes_left
from arl_tui.calibration.texts import SOMETIMES_NOTHING, TITLES, instruction
from arl_tui.participants import FEEDBACK_LAG, SIMPLE, TaskDelay
from arl_tui.screens.page import PageScreen
from studies.reaction_time.protocol import BlockPlan, Schedule

ENTER_OR_STOP: list[BindingType] = [
    Binding("enter", "answer(True)", "Go on", id="page.yes", tooltip="Go on"),
    Binding("q,ctrl+q,ctrl+c", "answer(False)", "Stop", id="page.no", tooltip="Stop; what is done is kept"),
]


class Reading(PageScreen):
    """A page that is left with yes or no."""

    BINDINGS: ClassVar[list[BindingType]] = ENTER_OR_STOP
    CALL = "Press [reverse] Enter [/] to go on, [reverse] Q [/] to stop"

    def paragraphs(self) -> Iterable[str]:
        """Return the text, in markup."""
        raise NotImplementedError

    def body(self) -> Iterable[Widget]:
        """Return the text and what can be pressed."""
        yield Static("\n\n".join(self.paragraphs()))
        yield Static(self.CALL, classes="call")

    def action_answer(self, yes: bool) -> None:
        """Leave with the answer."""
        self.leave(yes)


class HindrancePage(Reading, inherit_bindings=False):
    """Something stands between keyboard and program: measuring needs an explicit yes."""

    HEADING = "The times measured here may be wrong"
    CALL = "Press [reverse] Y [/] to measure all the same, [reverse] Q [/] to leave"
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("y", "answer(True)", "Measure", id="hindrance.yes", tooltip="Measure all the same"),
        Binding("n,q,ctrl+q,ctrl+c", "answer(False)", "Leave", id="hindrance.no", tooltip="Leave"),
    ]

    def __init__(self, hindrances: Sequence[str]) -> None:
        super().__init__()
        self._hindrances = hindrances

    def paragraphs(self) -> Iterable[str]:
        """Return what stands in between, and what that does."""
        yield "Between your keyboard and this program there is [b]" + " and ".join(self._hindrances) + "[/]."
        yield (
            "It holds pictures and key presses up by an unknown time, which can differ from press to press. "
            "For a measurement open a terminal on this computer itself and run the command there."
        )
        yield "If you go on, this is written down with the measurement."


class OldSessionPage(Reading, inherit_bindings=False):
    """A half session of another day."""

    HEADING = "An unfinished session"
    CALL = "Press [reverse] N [/] to begin a new one, [reverse] C [/] to continue the old one"
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("c", "answer(True)", "Continue", id="old.continue", tooltip="Continue the old session"),
        Binding("n,enter", "answer(False)", "New", id="old.new", tooltip="Begin a new session"),
    ]

    def __init__(self, old: Unfinished) -> None:
        super().__init__()
        self._old = old

    def paragraphs(self) -> Iterable[str]:
        """Return how old it is and how far it got."""
        done = sum(len(part.done) for part in self._old.parts)
        total = sum(len(part.schedule.trials) for part in self._old.parts)
        yield (
            f"This participant stopped [b]{self._old.age_h:.0f} hours ago[/] after {done} of {total} trials. "
            "Another day is another measurement, so a new session is better. The old one is kept in any case."
        )


class WelcomePage(Reading):
    """What will happen."""

    HEADING = "How fast do you react?"

    def __init__(self, parts: Sequence[Part], participant: str, *, resumed: bool) -> None:
        super().__init__()
        self._parts = [part for part in parts if not part.complete]
        self._participant = participant
        self._resumed = resumed

    def paragraphs(self) -> Iterable[str]:
        """Return the explanation."""
        if self._resumed:
            yield "[b]Welcome back.[/] We go on where you stopped."
        n, minutes = len(self._parts), max(1, round(minutes_left(self._parts)))
        tasks = "one short task" if n == 1 else f"{n} short tasks"
        titles = ", ".join(TITLES[part.schedule.config.task] for part in self._parts)
        length = "a minute" if minutes == 1 else f"{minutes} minutes"
        yield (
            f"You will do {tasks} ({titles}), together about [b]{length}[/], with breaks. "
            "Each begins with an explanation and some practice."
        )
        yield (
            "Sit comfortably, look at the middle of the screen, and leave your fingers on [reverse b] F [/], "
            "[reverse b] J [/] and [reverse b] Space [/]. Press a key once and let it go at once."
        )
        yield (
            "[dim]Your key presses and their times are written to a file on this computer under the code[/] "
            f"[b]{self._participant}[/][dim]. You can pause or stop at any time; what is done is kept.[/]"
        )


class InstructionPage(Reading):
    """How one task goes."""

    def __init__(self, schedule: Schedule, block: BlockPlan, *, resumed: bool) -> None:
        super().__init__()
        self._schedule = schedule
        self._block = block
        self._resumed = resumed
        self.HEADING = TITLES[schedule.config.task]

    def paragraphs(self) -> Iterable[str]:
        """Return the instruction."""
        config = self._schedule.config
        if self._block.practice:
            count = len(self._block.trials)
            times = "once" if count == 1 else f"{count} times"
            ending = f"First {times} for practice: you are told how you did."
        elif self._resumed or not config.n_practice:
            ending = "This counts: you are not told how you did."
        else:
            yield "[b]Practice is over.[/] From now on it counts, and you are not told how you did."
            ending = ""
        yield instruction(config)
        if config.catch_rate and config.task != "go/no-go":
            yield SOMETIMES_NOTHING
        if ending:
            yield ending


class BreakPage(Reading):
    """A rest between two blocks."""

    HEADING = "A break"

    def __init__(self, done: int, total: int) -> None:
        super().__init__()
        self._done = done
        self._total = total

    def paragraphs(self) -> Iterable[str]:
        """Return how much is done."""
        filled = round(30 * self._done / self._total)
        yield "Rest your eyes for a moment. Take as long as you like."
        yield (
            f"This task: [$primary]{'━' * filled}[/][dim]{'━' * (30 - filled)}[/] {self._done} of "
            f"{self._total}"
        )


def page_before(schedule: Schedule, block: BlockPlan, n_done: int, *, fresh: bool, resumed: bool) -> Reading:
    """Return what is read before a block: how the task goes, or that there is a break.

    Args:
        schedule: of the task.
        block: the block that comes.
        n_done: trials of the task that are done.
        fresh: whether this is the first block since the command was given.
        resumed: whether some of the task's trials were done before.
    """
    first_scored = next(each.index for each in schedule.blocks if not each.practice)
    if fresh or block.index == first_scored:
        return InstructionPage(schedule, block, resumed=fresh and resumed)
    return BreakPage(n_done, len(schedule.trials))


class PausePage(Reading):
    """The participant has asked for a pause, in the middle of a trial."""

    HEADING = "Pause"

    def paragraphs(self) -> Iterable[str]:
        """Return what becomes of the trial."""
        yield "Take as long as you like. The last one will come again; nothing else is lost if you stop."


class WaitingPage(PageScreen):
    """Something is being worked out; the app takes this page away."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("ctrl+q,ctrl+c", "give_up", "Stop", id="waiting.stop", tooltip="Do not wait")
    ]

    def __init__(self, heading: str, text: str) -> None:
        super().__init__()
        self.HEADING = heading
        self._text = text

    def body(self) -> Iterable[Widget]:
        """Return the text."""
        yield Static(self._text)

    def action_give_up(self) -> None:
        """Leave without what was waited for."""
        self.leave(False)


class SummaryPage(Reading, inherit_bindings=False):
    """How it went: each task's delay in plain words, and where everything is."""

    CALL = "Press [reverse] Enter [/] to leave"
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("enter,q,ctrl+q,ctrl+c", "answer(True)", "Leave", id="summary.leave", tooltip="Leave")
    ]

    def __init__(self, fitted: Fitted, *, finished: bool, trouble: str | None) -> None:
        super().__init__()
        self._fitted = fitted
        self._finished = finished
        self._trouble = trouble
        self.HEADING = "Thank you!" if trouble is None else "The session had to end early"

    def body(self) -> Iterable[Widget]:
        """Return what happened."""
        if self._trouble is not None:
            yield Static(Text(self._trouble), classes="trouble")
        yield from super().body()

    def paragraphs(self) -> Iterable[str]:
        """Return the results."""
        if not self._finished:
            yield "What you have done is kept. To go on within 12 hours, run the same command again."
        for delay in self._fitted.delays:
            yield result_words(delay)
        tasks = {delay.task for delay in self._fitted.delays}
        if {SIMPLE, FEEDBACK_LAG} <= tasks:
            yield "[dim]Reacting is not judging: the agent is taught with the delay of judging.[/]"
        for task in self._fitted.failures:
            yield f"[b]{title_of(task)}[/]: no result. The experimenter sees why."


def title_of(task: str) -> str:
    """Return what the participant knows a task as; `task` may be followed by a comma and more."""
    name, comma, more = task.partition(",")
    titles = {"all": "All tasks"} | {str(known): title for known, title in TITLES.items()}
    return f"{titles.get(name, name)}{comma}{more}"


def result_words(delay: TaskDelay) -> str:
    """Return one task's result in plain words, in markup; warnings stand in the terminal only."""
    mean = delay.mean_s
    told = (
        f"[b]{TITLES[delay.task]}[/]: on average you took [b]{mean.estimate:.2f} s[/] (95 % sure: "
        f"{mean.low:.2f} to {mean.high:.2f} s; {delay.n_observed} answers"
    )
    return told + (f", {delay.n_censored} without one)." if delay.n_censored else ").")
