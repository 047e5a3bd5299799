"""Keepaway in the play screen: the pitch, smooth between cycles, and the figures of the game."""

from collections.abc import Iterable, Sequence

from textual.geometry import Size
from textual.widget import Widget
from textual.widgets import Static

from arl_tui.app.link import Picture, TakenFor
from arl_tui.drawing_rate import FRAME_S
from arl_tui.games.panel import SMALLEST, Progress
from arl_tui.games.rendering import Place
from arl_tui.language import tr, trn
from arl_tui.palette import Palette
from arl_tui.widgets.pitch import PitchWidget
from arl_tui.widgets.pitch_drawing import smallest
from arl_tui.widgets.stats import trend
from core.keepaway.picture import PitchFrame, between
from core.keepaway.pitch import KeepawayConfig
from core.numerics.clock import Clock, MonotonicClock
from core.session.protocol import Protocol

BESIDE = 36
"""Columns beside the pitch."""
KEPT_SHOWN = 3
"""Durations of so many games are shown."""
TREND_WIDTH = 12
LABEL = 11
"""Cells of a label before its figure."""


class LivePitch(PitchWidget):
    """A pitch that draws what lies between the picture it has and the one that comes next."""

    def __init__(self, config: KeepawayConfig, palette: Palette, clock: Clock, *, smooth: bool) -> None:
        super().__init__(config.length_m, config.width_m, beside=BESIDE, palette=palette)
        self._smooth = smooth
        self._clock = clock
        self._picture: Picture | None = None
        self._since_ns = 0
        self.taken = -1
        """Number of the newest picture whose drawing has been told of."""

    def on_mount(self) -> None:
        """Begin to draw smoothly, unless movement is to be reduced."""
        if self._smooth:
            self.set_interval(FRAME_S, self._slide)

    def take(self, picture: Picture) -> None:
        """Draw a picture with the next paint, even if it looks like the one before."""
        assert isinstance(picture.view, PitchFrame), "a worker that plays Keepaway sends pitches"
        self._picture, self._since_ns = picture, self._clock.now_ns()
        if not self.show(picture.view, picture.number):
            self.refresh()

    def _slide(self) -> None:
        picture = self._picture
        if picture is None or picture.ahead is None or self.drawn_frame != picture.number:
            return
        assert isinstance(picture.view, PitchFrame)
        assert isinstance(picture.ahead, PitchFrame)
        fraction = (self._clock.now_ns() - self._since_ns) / picture.lasts_ns
        # Never the next picture itself: another step may begin with it.
        self.show(between(picture.view, picture.ahead, min(fraction, 0.99)), picture.number)


class KeepawayPanel:
    """The pitch, and the score beside it."""

    def __init__(self, protocol: Protocol, palette: Palette, *, clock: Clock | None = None) -> None:
        """Draw an empty pitch of the protocol's size."""
        assert isinstance(protocol.domain, KeepawayConfig), "a protocol of Keepaway"
        smooth = not protocol.screen.reduced_motion
        self.pitch = LivePitch(protocol.domain, palette, clock or MonotonicClock(), smooth=smooth)
        least = smallest(protocol.domain.length_m, protocol.domain.width_m)
        self.needed = Size(max(SMALLEST.width, least.columns + BESIDE), max(SMALLEST.height, least.lines + 1))
        """Columns and lines without which the game does not fit."""
        self._score = Static(id="score")
        self._score.border_title = tr("Progress")
        self._written = ""

    def take_drawn(self) -> bool:
        """Return whether a picture has been drawn of which this has not been said; what lies between is
        none.
        """
        drawn = self.pitch.drawn_frame
        fresh = drawn != self.pitch.taken and drawn >= 0
        self.pitch.taken = drawn
        return fresh

    def game_widget(self) -> PitchWidget:
        """Return the pitch."""
        return self.pitch

    def figures(self) -> Iterable[Widget]:
        """Return the score."""
        return (self._score,)

    def show(self, picture: Picture, progress: Progress) -> None:
        """Draw a pitch."""
        self.pitch.take(picture)
        score = "\n".join(_score_lines(progress))
        if score != self._written:
            self._written = score
            self._score.update(score)

    def refresh(self) -> None:
        """Draw the pitch once more, and say so."""
        self.pitch.taken = -1
        self.pitch.refresh()

    def title(self, text: str) -> None:
        """Write into the pitch's boundary."""
        self.pitch.title = text

    def part(self, text: str) -> None:
        """Write into the border of the figures."""
        self._score.border_title = text

    def mark(self, taken: TakenFor) -> str:
        """Mark the keeper who chose, and who was passed to."""
        if taken.step < 0 or not taken.place:
            return tr("but no option was on screen")
        ((player, target),) = taken.place
        if taken.value != 0:  # a mark is good or bad
            self.pitch.mark(player, target, good=taken.value > 0)
        keeper = f"K{player + 1}"
        if target < 0:
            return tr("for {keeper} holding the ball", keeper=keeper)
        return tr("for {keeper}'s pass to {target}", keeper=keeper, target=f"K{target + 1}")

    def unmark(self) -> None:
        """Take the mark away."""
        self.pitch.unmark()

    def pose(self, places: Sequence[Place], keys: Sequence[str]) -> None:
        """Write each option's key beside the keeper who would have the ball."""
        players = [player if target < 0 else target for ((player, target),) in places]
        self.pitch.pose(tuple(zip(players, keys, strict=False)))

    def unpose(self) -> None:
        """Take the keys away."""
        self.pitch.pose(())

    def presses_left(self, presses: int | None) -> None:
        """Write them into the pitch's boundary, where the eye is."""
        if presses is None:
            self.pitch.note = ""
            return
        self.pitch.note = trn("{n} press left", "{n} presses left", presses)


def _score_lines(progress: Progress) -> Iterable[str]:
    """Yield at most four lines of at most 31 characters."""
    yield f"{tr('Game'):<{LABEL}}{tr('{done} of {all}', done=progress.episode, all=progress.episodes)}"
    kept = [f"{seconds:.1f}" for seconds in progress.performances]
    if kept:
        yield f"{tr('Kept'):<{LABEL}}{' '.join(kept[-KEPT_SHOWN:])} s"
        yield f"{tr('Best'):<{LABEL}}{max(progress.performances):.1f} s"
    weights = progress.human_weights
    if weights:
        yield f"{tr('Influence'):<{LABEL}}{weights[-1]:.2f}  {trend(weights, TREND_WIDTH)}"
