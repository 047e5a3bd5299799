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
from arl_tui.language import later, tr, trn
from arl_tui.participants import FEEDBACK_LAG, SIMPLE, TaskDelay
from arl_tui.screens.page import PageScreen
from arl_tui.words import judging_text
from studies.reaction_time.protocol import BlockPlan, Schedule

ENTER_OR_STOP: list[BindingType] = [
    Binding("enter", "answer(True)", "Go on", id="page.yes", tooltip="Go on"),
    Binding("q,ctrl+q,ctrl+c", "answer(False)", "Stop", id="page.no", tooltip="Stop; what is done is kept"),
]


class Reading(PageScreen):
    """A page that is left with yes or no."""

    BINDINGS: ClassVar[list[BindingType]] = ENTER_OR_STOP
    CALL = later("Press {key_enter} to go on, {key_stop} to stop")
    """In English, marked with `later`."""

    def paragraphs(self) -> Iterable[str]:
        """Return the text, in markup."""
        raise NotImplementedError

    def body(self) -> Iterable[Widget]:
        """Return the text and what can be pressed."""
        yield Static("\n\n".join(self.paragraphs()))
        yield Static(tr(self.CALL), classes="call")

    def action_answer(self, yes: bool) -> None:
        """Leave with the answer."""
        self.leave(yes)


class HindrancePage(Reading, inherit_bindings=False):
    """Something stands between keyboard and program: measuring needs an explicit yes."""

    HEADING = later("The times measured here may be wrong")
    CALL = later("Press {key_yes} to measure all the same, {key_stop} to leave")
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("y", "answer(True)", "Measure", id="hindrance.yes", tooltip="Measure all the same"),
        Binding("n,q,ctrl+q,ctrl+c", "answer(False)", "Leave", id="hindrance.no", tooltip="Leave"),
    ]

    def __init__(self, hindrances: Sequence[str]) -> None:
        super().__init__()
        self._hindrances = hindrances

    def paragraphs(self) -> Iterable[str]:
        """Return what stands in between, and what that does."""
        between = tr(" and ").join(tr(each) for each in self._hindrances)
        yield tr("Between your keyboard and this program there is [b]{between}[/].", between=between)
        yield tr(
            "It holds pictures and key presses up by an unknown time, which can differ from press to press. "
            "For a measurement open a terminal on this computer itself and run the command there."
        )
        yield tr("If you go on, this is written down with the measurement.")


class OldSessionPage(Reading, inherit_bindings=False):
    """A half session of another day."""

    HEADING = later("An unfinished session")
    CALL = later("Press {key_new} to begin a new one, {key_continue} to continue the old one")
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
        yield tr(
            "This participant stopped [b]{hours:.0f} hours ago[/] after {done} of {total} trials. Another "
            "day is another measurement, so a new session is better. The old one is kept in any case.",
            hours=self._old.age_h,
            done=done,
            total=total,
        )


class WelcomePage(Reading):
    """What will happen."""

    HEADING = later("How fast do you react?")

    def __init__(self, parts: Sequence[Part], participant: str, *, resumed: bool) -> None:
        super().__init__()
        self._parts = [part for part in parts if not part.complete]
        self._participant = participant
        self._resumed = resumed

    def paragraphs(self) -> Iterable[str]:
        """Return the explanation."""
        if self._resumed:
            yield tr("[b]Welcome back.[/] We go on where you stopped.")
        n, minutes = len(self._parts), max(1, round(minutes_left(self._parts)))
        yield tr(
            "You will do {tasks} ({titles}), together about [b]{length}[/], with breaks. "
            "Each begins with an explanation and some practice.",
            tasks=trn("one short task", "{n} short tasks", n),
            titles=", ".join(tr(TITLES[part.schedule.config.task]) for part in self._parts),
            length=trn("a minute", "{n} minutes", minutes),
        )
        yield judging_text(
            "Sit comfortably, look at the middle of the screen, and leave your fingers on {no}, {yes} and "
            "{space}. Press a key once and let it go at once."
        )
        yield tr(
            "[dim]Your key presses and their times are written to a file on this computer under the code[/] "
            "[b]{code}[/][dim]. You can pause or stop at any time; what is done is kept.[/]",
            code=self._participant,
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
            ending = trn(
                "First once for practice: you are told how you did.",
                "First {n} times for practice: you are told how you did.",
                count,
            )
        elif self._resumed or not config.n_practice:
            ending = tr("This counts: you are not told how you did.")
        else:
            yield tr("[b]Practice is over.[/] From now on it counts, and you are not told how you did.")
            ending = ""
        yield instruction(config)
        if config.catch_rate and config.task != "go/no-go":
            yield tr(SOMETIMES_NOTHING)
        if ending:
            yield ending


class BreakPage(Reading):
    """A rest between two blocks."""

    HEADING = later("A break")

    def __init__(self, done: int, total: int) -> None:
        super().__init__()
        self._done = done
        self._total = total

    def paragraphs(self) -> Iterable[str]:
        """Return how much is done."""
        filled = round(30 * self._done / self._total)
        yield tr("Rest your eyes for a moment. Take as long as you like.")
        yield tr(
            "This task: {bar} {done} of {all}",
            bar=f"[$primary]{'━' * filled}[/][dim]{'━' * (30 - filled)}[/]",
            done=self._done,
            all=self._total,
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

    HEADING = later("Pause")

    def __init__(self, reminder: str = "") -> None:
        """Prepare; `reminder` says which key means what, in the language in use."""
        super().__init__()
        self._reminder = reminder

    def paragraphs(self) -> Iterable[str]:
        """Return which key means what, and what becomes of the trial."""
        if self._reminder:
            yield self._reminder
        yield tr("Take as long as you like. The last one will come again; nothing else is lost if you stop.")


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
        yield Static(tr(self._text))

    def action_give_up(self) -> None:
        """Leave without what was waited for."""
        self.leave(False)


class SummaryPage(Reading, inherit_bindings=False):
    """How it went: each task's delay in plain words, and where everything is."""

    CALL = later("Press {key_enter} to leave")
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("enter,q,ctrl+q,ctrl+c", "answer(True)", "Leave", id="summary.leave", tooltip="Leave")
    ]

    def __init__(self, fitted: Fitted, *, finished: bool, trouble: str | None) -> None:
        super().__init__()
        self._fitted = fitted
        self._finished = finished
        self._trouble = trouble
        self.HEADING = later("Thank you!") if trouble is None else later("The session had to end early")

    def body(self) -> Iterable[Widget]:
        """Return what happened."""
        if self._trouble is not None:
            yield Static(Text(self._trouble), classes="trouble")
        yield from super().body()

    def paragraphs(self) -> Iterable[str]:
        """Return the results."""
        if not self._finished:
            yield tr("What you have done is kept. To go on within 12 hours, run the same command again.")
        for delay in self._fitted.delays:
            yield result_words(delay)
        tasks = {delay.task for delay in self._fitted.delays}
        if {SIMPLE, FEEDBACK_LAG} <= tasks:
            yield tr("[dim]Reacting is not judging: the agent is taught with the delay of judging.[/]")
        for task in self._fitted.failures:
            yield tr("[b]{task}[/]: no result. The experimenter sees why.", task=title_of(task))


def title_of(task: str) -> str:
    """Return what the participant knows a task as; `task` may be followed by a comma and more."""
    name, comma, more = task.partition(",")
    titles = {"all": tr("All tasks")} | {str(known): tr(title) for known, title in TITLES.items()}
    return f"{titles.get(name, name)}{comma}{more}"


def result_words(delay: TaskDelay) -> str:
    """Return one task's result in plain words, in markup; warnings stand in the terminal only."""
    mean = delay.mean_s
    said = {
        "task": tr(TITLES[delay.task]),
        "mean": mean.estimate,
        "low": mean.low,
        "high": mean.high,
        "answers": delay.n_observed,
    }
    if not delay.n_censored:
        return tr(
            "[b]{task}[/]: on average you took [b]{mean:.2f} s[/] (95 % sure: {low:.2f} to {high:.2f} s; "
            "{answers} answers).",
            **said,
        )
    return tr(
        "[b]{task}[/]: on average you took [b]{mean:.2f} s[/] (95 % sure: {low:.2f} to {high:.2f} s; "
        "{answers} answers, {missing} without one).",
        missing=delay.n_censored,
        **said,
    )
