"""Confirms the key presses of several participants: a few lines for each, always in the same place."""

from asyncio import TimerHandle
from collections.abc import Sequence
from dataclasses import dataclass

from textual.strip import Strip

from arl_tui.app.once import after
from arl_tui.feedback_words import kind_of, short_words, word_of
from arl_tui.language import tr
from arl_tui.widgets.feedback_bar import REFUSALS, SAVING, FeedbackBar
from core.events import KeyPressed, PressRetracted
from core.feedback.keys import KeyConfig

MOST_PIPS = 8
"""A larger budget is written in figures."""


@dataclass
class _Line:
    """What the bar says to one person."""

    name: str
    keys: KeyConfig
    presses_left: int
    word: str = ""
    kind: str = "idle"
    note: str = ""
    timer: TimerHandle | None = None


class PeopleBar(FeedbackBar):
    """Name, last press, presses left and keys of each participant; nothing moves when another one presses."""

    def __init__(self, people: Sequence[tuple[str, KeyConfig]], *, id: str | None = None) -> None:
        """Show all participants' keys and a full budget.

        Args:
            people: name and keys of each, in order; at least one.
            id: Textual's name of the widget.
        """
        super().__init__(people[0][1], id=id)
        self._people = [_Line(name, keys, keys.max_presses_per_episode) for name, keys in people]
        self._person_of: dict[int, int] = {}
        self._high = max(1, min(3, self.LINES_HIGH // len(people)))
        """Lines for each person."""

    def said_to(self, person: int) -> tuple[str, str]:
        """Return the word and the note that stand in a participant's line."""
        return self._people[person].word, self._people[person].note

    def begin_game(self, presses_left: int) -> None:
        """Clear the bar and show all participants' new budget; `presses_left` is that of the first."""
        for person, line in enumerate(self._people):
            line.presses_left = line.keys.max_presses_per_episode
            self._tell(person, "", "idle", "")
        self.border_subtitle = ""

    def show_press(self, press: KeyPressed, presses_left: int) -> None:
        """Confirm an accepted press in the line of its person, or say there why it does not count."""
        self.border_subtitle = ""
        if press.person < 0:
            if press.verdict != "repeat":
                advice = self._foreign_keys.advice(press.key, read=bool(press.read_as))
                self.border_subtitle = advice or tr(REFUSALS[press.verdict])
            return
        line = self._people[press.person]
        line.presses_left = presses_left
        if press.verdict == "accepted":
            assert press.value is not None, f"an accepted press has a value: {press}"
            self._person_of[press.press] = press.person
            self._tell(press.person, word_of(press.value).upper(), kind_of(press.value), tr("counted"))
        elif press.verdict not in ("repeat", "other"):
            self._tell(press.person, "", "idle", tr(REFUSALS[press.verdict]))

    def show_taken(self, taken: str, press: int) -> None:
        """Say what a press that has just been confirmed was taken for, in its person's line."""
        line = self._people[self._person_of.get(press, 0)]
        if line.note == tr("counted"):
            line.note = taken
            self.refresh()

    def show_retraction(self, retraction: PressRetracted, presses_left: int) -> None:
        """Say to its person that a press does not count after all."""
        person = self._person_of.get(retraction.press, 0)
        line = self._people[person]
        line.presses_left = presses_left
        if retraction.reason == "auto-repeat":
            self._tell(person, line.word, line.kind, tr("a key held down counts once"))
        else:
            self._tell(person, tr("TAKEN BACK"), "back", tr("does not count"))

    def show_saving(self, saving: bool) -> None:
        """Say that the disk is behind, or no longer say so."""
        if saving != self.saving:
            self.saving = saving
            self.border_subtitle = tr(SAVING) if saving else ""

    def show_not_saved(self) -> None:
        """Say that nothing counts any more."""
        self.border_subtitle = tr("Not saved: nothing counts any more")

    def _tell(self, person: int, word: str, kind: str, note: str) -> None:
        line = self._people[person]
        line.word, line.kind, line.note = word, kind, note
        if line.timer is not None:
            line.timer.cancel()
            line.timer = None
        if (word or note) and self._hold_s > 0:
            line.timer = after(self, self._hold_s, lambda: self._fade_of(person))
        self.refresh()

    def _fade_of(self, person: int) -> None:
        line = self._people[person]
        line.timer = None
        line.word, line.kind, line.note = "", "idle", ""
        self.refresh()

    def render_line(self, y: int) -> Strip:
        """Return one line: of each participant what was said, below it budget and keys."""
        person, line = divmod(y, self._high)
        if person >= len(self._people):
            return self._line([])
        if line == 0:
            return self._left(self._said(self._people[person]))
        return self._left(self._budget_and_keys(self._people[person]) if line == 1 else [])

    def _said(self, line: _Line) -> list[tuple[str, str]]:
        widest = max(len(each.name) for each in self._people)
        parts = [("key", f" {line.name:{widest}} ")]
        if self._high == 1:
            parts.append(("pip", f" {line.presses_left} "))
            parts.append(("label", "".join(f"{key.upper()} " for key in line.keys.letters)))
        if line.word:
            parts += [("label", " "), (line.kind, f" {line.word} ")]
        return [*parts, ("note", f" {line.note}")]

    def _budget_and_keys(self, line: _Line) -> list[tuple[str, str]]:
        most, left = line.keys.max_presses_per_episode, line.presses_left
        if most <= MOST_PIPS:
            parts = [("pip", f" {'●' * left}"), ("spent", "○" * (most - left))]
        else:
            parts = [("label", " " + tr("{left} left", left=left))]
        parts.append(("label", " "))
        for key, word in (*short_words(line.keys), (line.keys.retract, tr("back"))):
            parts += [("key", f" {key.upper()} "), ("label", word)]
        return parts

    def _left(self, parts: list[tuple[str, str]]) -> Strip:
        """Return a line of styled parts from the left edge."""
        strip = self._joined(parts)
        return strip.adjust_cell_length(self.size.width, self.rich_style)
