"""Whether the answers of a recording follow from its questions and key presses (`core.session.inputs`)."""

from typing import NoReturn

from core.events import KeyPressed, QuestionAnswered, QuestionPosed
from core.feedback.asking_config import ANTICIPATED_NS, NO_ANSWER, AskingConfig
from core.numerics.clock import NS_PER_S


class Impossible(ValueError):
    """An event cannot have happened where it stands."""


def refuse(reason: str) -> NoReturn:
    """Say why an event cannot have happened.

    Raises:
        Impossible: always.
    """
    raise Impossible(reason)


class QuestionsFollowed:
    """Follows which question is open, and whether its answer follows from the key that was pressed."""

    def __init__(self, asking: AskingConfig) -> None:
        """Follow a session whose protocol has these keys and this limit."""
        self._asking = asking
        self._open: QuestionPosed | None = None
        self._pressed: KeyPressed | None = None

    def posed(self, question: QuestionPosed) -> None:
        """Take in a question."""
        self._open, self._pressed = question, None

    def pressed(self, press: KeyPressed) -> None:
        """Take in a key press, whatever it means."""
        self._pressed = press

    def forget(self) -> None:
        """Begin anew: the session goes on in another file."""
        self._open = self._pressed = None

    def answered(self, answer: QuestionAnswered, clocks_agree_ns: int, *, covered: bool) -> None:
        """Take in an answer; `covered` says whether something lies over the game, as a question does.

        Raises:
            Impossible: there is no such question, or the answer is another one.
        """
        if not covered:
            refuse(f"question {answer.question} is answered, and the game is on screen")
        posed, self._open = self._open, None
        if posed is None or posed.question != answer.question:
            refuse(f"question {answer.question} is answered, and is not the one that was posed last")
        if answer.shown_ns < posed.time_ns - clocks_agree_ns:
            refuse(f"question {answer.question} is on screen at {answer.shown_ns} ns, before it was posed")
        on_screen_ns = answer.time_ns - answer.shown_ns
        if answer.answer == "time-limit":
            if answer.chosen >= 0 or on_screen_ns < self._asking.limit_s * NS_PER_S:
                refuse(f"question {answer.question} is taken back after {on_screen_ns} ns, before its limit")
            return
        self._check_key(posed, answer)
        if on_screen_ns < ANTICIPATED_NS:
            refuse(f"question {answer.question} is answered after {on_screen_ns} ns: nobody has read it")

    def _check_key(self, posed: QuestionPosed, answer: QuestionAnswered) -> None:
        press = self._pressed
        if press is None or (press.press, press.time_ns) != (answer.press, answer.time_ns):
            refuse(f"question {answer.question} is answered by a press that is not the last one")
        option = self._asking.option_of(press.read_as or press.key, len(posed.options))
        follows = -1 if option in (None, NO_ANSWER) else posed.options[option or 0]
        said = "none" if option == NO_ANSWER else "chosen"
        if option is None or (said, follows) != (answer.answer, answer.chosen):
            refuse(
                f"question {answer.question} is answered by {answer.chosen}; from the key {press.key!r} "
                f"follows {'no answer' if option is None else follows}"
            )
