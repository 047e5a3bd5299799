"""Watching a policy play Keepaway: the pitch, what the policy thinks, and keys for time. Nothing is
recorded.
"""

import threading
from collections.abc import Callable, Iterable
from typing import ClassVar

from textual import events
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal
from textual.geometry import Size
from textual.screen import Screen
from textual.timer import Timer
from textual.widget import Widget
from textual.widgets import Static

from arl_tui.app.plain_app import PlainApp
from arl_tui.drawing_rate import FRAME_S
from arl_tui.games.keepaway.playback import Playback, Source
from arl_tui.language import bold_cap, tr
from arl_tui.palette import STANDARD, palette_for
from arl_tui.screens.covers import SmallWindowScreen, fits_into
from arl_tui.screens.page import PageScreen
from arl_tui.themes import theme_in_use
from arl_tui.widgets.pitch import PitchWidget
from arl_tui.widgets.pitch_colours import legend
from arl_tui.widgets.pitch_drawing import smallest
from arl_tui.widgets.pitch_ink import DETAILS, Detail
from core.keepaway.pitch import END_REASONS, OUT
from core.numerics.clock import NS_PER_S, Clock, MonotonicClock

PANEL_S = 0.25
"""Figures are written at most this often, seconds."""
PANEL_WIDTH = 36
KEYS = (
    ("space", "pause"),
    (".", "step"),
    ("n", "next"),
    ("+ -", "speed"),
    ("d", "detail"),
    ("h", "help"),
    ("q", "quit"),
)
ENDS_SHOWN = 4


class HelpPage(PageScreen):
    """What is drawn, and all keys."""

    HEADING = "Watching Keepaway"
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("h,f1,q,space,enter,escape", "back", "Go on", id="watch-help.back", tooltip="Go on")
    ]

    def body(self) -> Iterable[Widget]:
        """Return the text."""
        yield Static(
            "The keepers (K) pass the ball among themselves; the takers (T) want it. An episode ends when a "
            "taker has had the ball for a moment, or the ball leaves the square. The mark beside a player "
            "shows which way it faces; the bright player has the ball; dots lead to the receiver of a pass.\n"
        )
        rows = (
            ("space", "pause, and go on"),
            (".", "one cycle (a tenth of a second), then stand still"),
            ("n", "next episode"),
            ("+", "faster"),
            ("-", "slower; the time shown stays the game's"),
            ("d", "letters, half-blocks or braille"),
            ("q", "quit"),
        )
        widest = max(len(key) for key, _ in rows)
        for key, meaning in rows:
            yield Static(f"  {bold_cap(key)}{' ' * (widest - len(key))}  {meaning}")
        yield Static("Press [reverse] Space [/] to go on", classes="call")

    def action_back(self) -> None:
        """Go on."""
        self.leave(True)


class WatchScreen(Screen[None], inherit_bindings=False):
    """Draws what a playback shows."""

    BINDING_GROUP_TITLE = "Watching"
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("space,p", "pause", "pause", id="watch.pause", tooltip="Stand still, or go on"),
        Binding("full_stop,right", "step", "step", id="watch.step", tooltip="One cycle"),
        Binding("n", "next", "next", id="watch.next", tooltip="The next episode"),
        Binding("plus,equals_sign,up", "faster", "faster", id="watch.faster", tooltip="Faster"),
        Binding("minus,down", "slower", "slower", id="watch.slower", tooltip="Slower"),
        Binding("d", "detail", "detail", id="watch.detail", tooltip="Another rendering"),
        Binding("h,f1", "guide", "help", id="watch.help", tooltip="Keys and marks"),
        Binding("q,ctrl+q,ctrl+c", "leave", "quit", id="watch.quit", tooltip="Leave"),
    ]
    AUTO_FOCUS = None
    ALLOW_SELECT = False
    DEFAULT_CSS = """
    WatchScreen { align: center top; background: $background; }
    WatchScreen > Horizontal { width: 1fr; height: 1fr; align: center middle; }
    WatchScreen #panel { width: 36; height: 1fr; padding: 0 0 0 2; }
    WatchScreen #watch-keys { width: 1fr; height: 1; text-align: center; color: $text-muted; }
    """

    def __init__(
        self,
        heading: str,
        *,
        length_m: float,
        width_m: float,
        speed: float = 1.0,
        episodes: int | None = None,
        detail: Detail | None = None,
        palette: str = STANDARD.name,
        clock: Clock | None = None,
    ) -> None:
        """Prepare an empty pitch.

        Args:
            heading: what is watched, a line or more for the panel.
            length_m: extent of the region from left to right.
            width_m: extent of the region downwards.
            speed: simulated seconds per second.
            episodes: leave after so many; None until the viewer leaves.
            detail: how fine; what the terminal can show by default.
            palette: name of the colours.
            clock: of the one who watches.
        """
        super().__init__()
        self.keys: tuple[tuple[str, str], ...] = KEYS
        """Keys and what they do, for the last line."""
        self.playback: Playback | None = None
        """None until the match is ready."""
        self._heading = heading
        self._speed = speed
        self._episodes = episodes
        self._clock = clock or MonotonicClock()
        self._length_m, self._width_m = length_m, width_m
        self._detail, self._palette = detail, palette
        least = smallest(length_m, width_m)
        self._needed = Size(max(80, least.columns + PANEL_WIDTH), max(24, least.lines + 1))
        self._written_ns = 0
        self._timer: Timer | None = None

    def compose(self) -> ComposeResult:
        """Lay out the pitch on the left, everything else on the right, keys below."""
        palette = palette_for(
            self._palette,
            self.app.console.color_system,
            no_color=self.app.no_color,
            theme=theme_in_use(),
        )
        self._palette = palette.name
        self.pitch = PitchWidget(
            self._length_m, self._width_m, detail=self._detail, beside=PANEL_WIDTH, palette=palette
        )
        with Horizontal():
            yield self.pitch
            yield Static(id="panel")
        yield Static("   ".join(f"[b]{key}[/] {meaning}" for key, meaning in self.keys), id="watch-keys")

    def on_mount(self) -> None:
        """Say that the match is not ready yet."""
        if self.playback is None:
            self.pitch.cover(tr("Getting ready ...\n\nThe first time this may take half a minute"))
        self.query_one("#panel", Static).update(self._heading)
        self._timer = self.set_interval(FRAME_S, self.draw)

    def begin(self, source: Source) -> None:
        """Start to play."""
        self.playback = Playback(source, self._clock, speed=self._speed)
        self.pitch.uncover()
        self.draw()

    def draw(self) -> None:
        """Draw the picture that is due; leave where the last episode asked for is over."""
        if self.playback is None or not self.is_current:
            return
        picture = self.playback.picture()
        if self._episodes is not None and picture.episode > self._episodes:
            self.action_leave()
            return
        self.pitch.show(picture)
        if self._clock.now_ns() - self._written_ns >= PANEL_S * NS_PER_S:
            self._write()

    def _write(self) -> None:
        if self.playback is None:
            return
        self._written_ns = self._clock.now_ns()
        self.query_one("#panel", Static).update("\n".join(self.panel()))

    def summary(self, ends: list[tuple[float, int]]) -> str:
        """Say in a line what the episodes were like; `ends` is (seconds, how it ended) of each."""
        return summary(ends)

    def panel(self) -> Iterable[str]:
        """Yield what stands beside the pitch, in markup."""
        yield self._heading
        if self.playback is not None:
            yield from panel_lines(self.playback, self._palette)

    # --- keys -----------------------------------------------------------------------------------------------

    def action_pause(self) -> None:
        """Stand still, or go on."""
        if self.playback is not None:
            self.playback.paused = not self.playback.paused
            self._write()

    def action_step(self) -> None:
        """Show one more cycle."""
        if self.playback is not None:
            self.playback.step()
            self.draw()
            self._write()

    def action_next(self) -> None:
        """Show the next episode."""
        if self.playback is not None:
            self.playback.next_episode()
            self.draw()
            self._write()

    def action_faster(self) -> None:
        """Play faster."""
        if self.playback is not None:
            self.playback.faster()
            self._write()

    def action_slower(self) -> None:
        """Play slower."""
        if self.playback is not None:
            self.playback.slower()
            self._write()

    def action_detail(self) -> None:
        """Draw in the next rendering."""
        self.pitch.detail = DETAILS[(DETAILS.index(self.pitch.detail) + 1) % len(DETAILS)]

    def action_guide(self) -> None:
        """Show marks and keys; time stands still."""
        self._lay_over(HelpPage())

    def action_leave(self) -> None:
        """Leave."""
        self.dismiss()

    def _leave_if(self, wanted: bool) -> None:
        if wanted:
            self.action_leave()

    def on_resize(self, event: events.Resize) -> None:
        """Ask for a larger window where the pitch could not be read."""
        if self.is_active and not fits_into(self._needed, event.size):
            self._lay_over(SmallWindowScreen(self._needed), lambda large: self._leave_if(large is False))

    def _lay_over(self, page: PageScreen, then: Callable[[bool | None], None] = lambda _: None) -> None:
        playback = self.playback
        went_on = playback is not None and not playback.paused
        if playback is not None:
            playback.paused = True

        def go_on(answer: bool | None) -> None:
            if playback is not None and went_on:
                playback.paused = False
            then(answer)

        self.app.push_screen(page, go_on)


def panel_lines(playback: Playback, palette: str) -> Iterable[str]:
    """Yield what stands below the heading, in markup."""
    yield f"Speed    x{playback.speed:g}{'   [reverse] PAUSED [/]' if playback.paused else ''}"
    yield ""
    ends = playback.ends
    if ends:
        yield f"Finished {len(ends)}, mean {sum(duration for duration, _ in ends) / len(ends):.1f} s"
        for duration, end in ends[: -ENDS_SHOWN - 1 : -1]:
            yield f"  {duration:6.1f} s {END_REASONS[end]}"
        yield ""
    yield from _value_lines(playback)
    yield from legend(palette)


def _value_lines(playback: Playback) -> Iterable[str]:
    if not playback.values:
        return
    picture, best = playback.picture(), max(value for _, value in playback.values)
    yield f"{picture.name(picture.decider)} expects to keep the ball for"
    for name, value in playback.values:
        yield f"  {name:5} {value / 10:6.1f} s {'<' if value == best else ''}"
    yield ""


def summary(ends: list[tuple[float, int]], *, unit: str = "episode", done: str = "watched") -> str:
    """Say in a line what the episodes were like that came to their end.

    Args:
        ends: how long each took, seconds, and how it ended.
        unit: what an episode is called.
        done: what was done with it.
    """
    if not ends:
        return f"No {unit} was {done} to its end."
    out = sum(end == OUT for _, end in ends)
    mean = sum(duration for duration, _ in ends) / len(ends)
    episodes = f"1 {unit}" if len(ends) == 1 else f"{len(ends)} {unit}s"
    return f"{episodes}: mean {mean:.1f} s; ball out {out}, taken {len(ends) - out}"


class WatchApp(PlainApp[str]):
    """One match; the app's result is a line about what was seen."""

    CSS_PATH = "../app.tcss"
    TITLE = "arl watch"

    def __init__(self, view: WatchScreen, prepare: Callable[[], Source], *, language: str = "en") -> None:
        """Prepare.

        Args:
            view: the screen.
            prepare: makes the match; takes a minute where everything has to be compiled first, and is called
                in another thread.
            language: of the words on screen that participants read.
        """
        super().__init__(language=language)
        self.view = view
        self.trouble: Exception | None = None
        """Why the match could not be prepared."""
        self._prepare = prepare
        self.thread = threading.Thread(target=self._get_ready, daemon=True)

    def on_mount(self) -> None:
        """Open the pitch, and close with it."""
        self.push_screen(self.view, callback=lambda _: self._finish())
        self.call_after_refresh(self.thread.start)

    def _get_ready(self) -> None:
        try:
            source = self._prepare()
        except Exception as error:  # noqa: BLE001 - told by the command that started the app
            self._tell(self._fail, error)
        else:
            self._tell(self.view.begin, source)

    def _tell(self, callback: Callable[..., None], argument: object) -> None:
        if self.is_running:
            self.call_from_thread(callback, argument)

    def _fail(self, error: Exception) -> None:
        self.trouble = error
        self.exit()

    def _finish(self) -> None:
        playback = self.view.playback
        ends = playback.ends if playback is not None else []
        self.exit(self.view.summary(ends))
