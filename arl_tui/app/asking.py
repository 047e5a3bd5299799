"""A question of the agent as the screen's process knows it: when it was on screen, and what answers it.

No widgets here: `arl_tui.screens.question` draws it, `arl_tui.app.live_session` records what comes of it.
"""

from core.events import KeyPressed, QuestionAnswered, QuestionPosed
from core.feedback.asking_config import ANTICIPATED_NS, NO_ANSWER, AskingConfig
from core.numerics.clock import NS_PER_S


class OpenQuestion:
    """The question that covers the game now."""

    def __init__(self, posed: QuestionPosed, config: AskingConfig) -> None:
        """Begin before the question has been drawn.

        Args:
            posed: what is asked.
            config: keys and limit.
        """
        self.posed = posed
        self._config = config
        self._frame = -1
        self._shown_ns: int | None = None

    def painted(self, frame: int) -> None:
        """Note the number of the frame on which all options are drawn; later ones change nothing."""
        if self._frame < 0:
            self._frame = frame

    def flushed(self, frame: int, time_ns: int) -> None:
        """Note when a frame has left for the terminal."""
        if frame == self._frame and self._shown_ns is None:
            self._shown_ns = time_ns

    @property
    def needs_frame(self) -> bool:
        """Whether it has not been drawn yet."""
        return self._frame < 0

    @property
    def is_shown(self) -> bool:
        """Whether its options have left for the terminal."""
        return self._shown_ns is not None

    def left_s(self, now_ns: int) -> float:
        """Return how much of the time is left, seconds; all of it while the question is not on screen."""
        since_ns = 0 if self._shown_ns is None else now_ns - self._shown_ns
        return self._config.limit_s - since_ns / NS_PER_S

    def answered_by(self, pressed: KeyPressed) -> QuestionAnswered | None:
        """Return what a key press answers; None where it is no answer, or came before it could be read."""
        option = self._config.option_of(pressed.read_as or pressed.key, len(self.posed.options))
        if option is None or self._shown_ns is None:
            return None
        if pressed.time_ns - self._shown_ns < ANTICIPATED_NS:
            return None
        return QuestionAnswered(
            question=self.posed.question,
            shown_ns=self._shown_ns,
            time_ns=pressed.time_ns,
            answer="none" if option == NO_ANSWER else "chosen",
            chosen=-1 if option == NO_ANSWER else self.posed.options[option],
            press=pressed.press,
        )

    def timed_out(self, now_ns: int) -> QuestionAnswered | None:
        """Return the record of a question whose time is up; None where it is not."""
        if self._shown_ns is None or self.left_s(now_ns) > 0:
            return None
        return QuestionAnswered(
            question=self.posed.question, shown_ns=self._shown_ns, time_ns=now_ns, answer="time-limit"
        )
