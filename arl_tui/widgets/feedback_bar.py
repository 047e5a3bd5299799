"""Confirms each key press at once, and says how many are left."""

from asyncio import TimerHandle
from collections.abc import Iterable
from textwrap import wrap
from typing import ClassVar

from rich.segment import Segment
from rich.style import Style
from textual.geometry import Size
from textual.strip import Strip
from textual.widget import Widget

from arl_tui.app.foreign_keys import ForeignKeys
from arl_tui.app.once import after
from arl_tui.feedback_words import kind_of, short_words, word_of
from arl_tui.language import later, tr
from arl_tui.widgets.big_letters import LINES, big
from core.events import KeyPressed, PressRetracted
from core.feedback.keys import KeyConfig

HOLD_S = 1.5
"""How long a word stays, seconds."""

WATCH = (later("watch, and say what you think"), later("watch"))
"""What stands where the word will be, as long as there is room for."""
WATCH_ONLY = (later("watch: no presses left in this game"), later("watch: no presses left"))
RESTING = (later("nothing to judge now"), later("wait"))
"""What stands there while no game is on screen."""
WRONG_ASKED = (
    later("Just once, on purpose: press the WRONG key"),
    later("On purpose: press the WRONG key"),
    later("press the WRONG key"),
)
SAVING = later("saving ...")
"""What stands below the presses left while the disk is behind."""
REFUSALS = {
    "no-presses-left": later("No presses left in this game: not counted"),
    "covered": later("The game has not begun: not counted"),
    "not-playing": later("No game on screen: not counted"),
    "other": later("This key has no meaning here"),
}


class FeedbackBar(Widget, inherit_bindings=False, can_focus=False):
    """A word in big letters, a note, the presses left, a request, and the keys.

    It decides nothing: it shows the records that `core.feedback.keys.PressGate` makes of key presses.
    """

    COMPONENT_CLASSES: ClassVar[set[str]] = {
        "feedback--good",
        "feedback--bad",
        "feedback--neither",
        "feedback--back",
        "feedback--idle",
        "feedback--note",
        "feedback--pip",
        "feedback--spent",
        "feedback--cue",
        "feedback--key",
        "feedback--label",
    }
    DEFAULT_CSS: ClassVar[str] = """
    FeedbackBar {
        width: 1fr;
        height: auto;
        border: round $foreground 40%;
        border-title-color: $foreground 75%;
    }
    FeedbackBar > .feedback--good { background: #1f7a4d; color: #ffffff; text-style: bold; }
    FeedbackBar > .feedback--bad { background: #b3372f; color: #ffffff; text-style: bold; }
    FeedbackBar > .feedback--neither { background: #4a5568; color: #ffffff; text-style: bold; }
    FeedbackBar > .feedback--back { background: #7a6a1f; color: #ffffff; text-style: bold; }
    FeedbackBar > .feedback--idle { color: $foreground 65%; }
    FeedbackBar > .feedback--note { color: $foreground; }
    FeedbackBar > .feedback--pip { color: $accent; text-style: bold; }
    FeedbackBar > .feedback--spent { color: $foreground 40%; }
    FeedbackBar > .feedback--cue { background: #e0a100; color: #000000; text-style: bold; }
    FeedbackBar > .feedback--key { color: $accent; text-style: bold; }
    FeedbackBar > .feedback--label { color: $foreground 80%; }
    """
    ALLOW_SELECT: ClassVar[bool] = False
    LINES_HIGH: ClassVar[int] = LINES + 7

    def __init__(
        self, keys: KeyConfig, *, hold_s: float = HOLD_S, id: str | None = None, classes: str | None = None
    ) -> None:
        """Show the keys and a full budget.

        Args:
            keys: which key means what, and how many presses an episode has.
            hold_s: how long a word stays, seconds; 0 keeps it until the next.
            id: Textual's name of the widget.
            classes: Textual's style classes.
        """
        super().__init__(id=id, classes=classes)
        self.border_title = tr("Your feedback")
        self.keys = keys
        self.presses_left = keys.max_presses_per_episode
        """Presses that still count in this episode."""
        self.wrong_asked = False
        """Whether one deliberately wrong press is asked for."""
        self.word = ""
        """What stands in big letters: GOOD, BAD, TAKEN BACK, a grade, or nothing."""
        self.note = ""
        """What stands below it."""
        self.resting = False
        """Whether there is nothing to judge: nothing on the bar asks for a press then."""
        self.saving = False
        """Whether the disk is behind with what has been recorded."""
        self._foreign_keys = ForeignKeys()
        self._counted = ""
        self._kind = "idle"
        self._hold_s = hold_s
        self._timer: TimerHandle | None = None

    def get_content_height(self, container: Size, viewport: Size, width: int) -> int:
        """Return the height, which never changes."""
        return self.LINES_HIGH

    def rest(self, resting: bool) -> None:
        """Ask for nothing while there is nothing to judge, or ask again."""
        if resting != self.resting:
            self.resting = resting
            self.refresh()

    def begin_game(self, presses_left: int) -> None:
        """Clear the bar and show a new budget."""
        self.presses_left = presses_left
        self._say("", "idle", "")

    def show_press(self, press: KeyPressed, presses_left: int) -> None:
        """Confirm an accepted press, or say why one does not count; a held key's repeats change nothing."""
        self.presses_left = presses_left
        self._counted = (
            tr("Counted by the simulated participant") if press.source == "simulated" else tr("Counted")
        )
        if press.verdict == "accepted":
            assert press.value is not None, f"an accepted press has a value: {press}"
            note = self._counted
            if press.layout:
                other = tr("{key} as {letter}: another keyboard layout", key=press.key, letter=press.read_as)
                note += f" {other}"
            self._say(word_of(press.value).upper(), kind_of(press.value), note)
        elif press.verdict != "repeat" and (press.read_as or press.key) != self.keys.retract:
            advice = self._foreign_keys.advice(press.key, read=bool(press.read_as))
            self._say("", "idle", advice or tr(REFUSALS[press.verdict]))

    def show_taken(self, taken: str, press: int) -> None:
        """Say what the press that has just been confirmed was taken for, while its word stands.

        Args:
            taken: in words.
            press: its number; of one participant always the press that has just been confirmed.
        """
        if self.note == self._counted:
            self.note += f" {taken}"
            self.refresh()

    def show_retraction(self, retraction: PressRetracted, presses_left: int) -> None:
        """Say that a press does not count after all."""
        self.presses_left = presses_left
        if retraction.reason == "auto-repeat":
            self._say(self.word, self._kind, tr("A key that is held down counts once"))
        else:
            self._say(tr("TAKEN BACK"), "back", tr("Your last press does not count"))

    def show_saving(self, saving: bool) -> None:
        """Say that the disk is behind, or no longer say so."""
        if saving != self.saving:
            self.saving = saving
            self.refresh()

    def show_not_saved(self) -> None:
        """Say that nothing counts any more."""
        self._say("", "idle", tr("Not saved: nothing counts any more"))

    def ask_wrong(self, asked: bool) -> None:
        """Ask for one deliberately wrong press, or stop asking."""
        if asked != self.wrong_asked:
            self.wrong_asked = asked
            self.refresh()

    def _say(self, word: str, kind: str, note: str) -> None:
        self.word, self._kind, self.note = word, kind, note
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        if (word or note) and self._hold_s > 0:
            self._timer = after(self, self._hold_s, self._fade)
        self.refresh()

    def _fade(self) -> None:
        self._timer = None
        self.word, self._kind, self.note = "", "idle", ""
        self.refresh()

    def render_line(self, y: int) -> Strip:
        """Return one line: the word (3), note, space, presses left, space, request, space, keys."""
        if y < LINES:
            return self._word_line(y)
        line = y - LINES
        if line in (0, 1):
            # Where there is little room a note takes the empty line below it as well.
            parts = wrap(self.note, max(1, self.size.width))
            return self._line([("note", parts[line] if line < len(parts) else "")])
        if line == 2:
            return self._line([] if self.resting else self._budget())
        if line == 3 and self.saving:
            return self._line([("note", tr(SAVING))])
        if line == 4 and self.wrong_asked and not self.resting:
            return self._filled("cue", self._longest(WRONG_ASKED))
        if line == 6 and not self.resting:
            return self._line(self._key_names())
        return self._line([])

    def _word_line(self, y: int) -> Strip:
        width = self.size.width
        if not self.word:
            waiting = RESTING if self.resting else WATCH if self.presses_left else WATCH_ONLY
            return self._filled("idle", self._longest(waiting) if y == 1 else "")
        # Two words in narrow letters are hard to tell apart.
        drawn = (big(self.word), big(self.word, narrow=" " not in self.word))
        lines = next((lines for lines in drawn if len(lines[0]) <= width), None)
        if lines is None:
            return self._filled(self._kind, self.word if y == 1 else "")
        return self._filled(self._kind, lines[y])

    def _budget(self) -> list[tuple[str, str]]:
        most = self.keys.max_presses_per_episode
        left = tr("{left} of {most} presses left", left=self.presses_left, most=most)
        if 2 * most + len(left) + 1 > self.size.width:
            return [("label", left)]
        return [
            ("pip", "● " * self.presses_left),
            ("spent", "○ " * (most - self.presses_left)),
            ("label", f" {left}"),
        ]

    def _key_names(self) -> list[tuple[str, str]]:
        back = tr("back") if self.keys.graded else tr("take back")
        names = [*short_words(self.keys), (self.keys.retract, back)]
        if not self.presses_left:
            names = names[-1:]  # a press taken back counts again; another one does not
        room = self.size.width - sum(len(f" {key} {name}") for key, name in names)
        gap = " " * min(4, max(1, room // len(names)))
        parts: list[tuple[str, str]] = []
        for key, name in names:
            parts += [("key", f" {key} "), ("label", f"{name}{gap}")]
        return parts

    def _longest(self, texts: tuple[str, ...]) -> str:
        """Return the first of several texts that fits, the last one where none does."""
        said = [tr(text) for text in texts]
        return next((text for text in said if len(text) <= self.size.width), said[-1])

    def _line(self, parts: Iterable[tuple[str, str]]) -> Strip:
        """Return a line of styled parts, centred."""
        strip = self._joined((name, text) for name, text in parts if text.strip())
        left = max(0, (self.size.width - strip.cell_length) // 2)
        return Strip([Segment(" " * left, self.rich_style), *strip]).adjust_cell_length(
            self.size.width, self.rich_style
        )

    def _joined(self, parts: Iterable[tuple[str, str]]) -> Strip:
        """Return styled parts one after the other."""
        return Strip([Segment(text, self._style(name)) for name, text in parts])

    def _filled(self, name: str, text: str) -> Strip:
        """Return a line in one style from edge to edge, its text centred."""
        width = self.size.width
        style = self._style(name)
        strip = Strip([Segment(text[:width], style)])
        left = (width - strip.cell_length) // 2
        right = width - strip.cell_length - left
        return Strip([Segment(" " * left, style), *strip, Segment(" " * right, style)], width)

    def _style(self, name: str) -> Style:
        return self.get_component_rich_style(f"feedback--{name}")
