"""Practice: a participant plays the agent's game with the agent's primitives. Nothing is recorded or
learned.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import ClassVar

from textual import events
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical
from textual.geometry import Size
from textual.screen import Screen
from textual.widget import Widget
from textual.widgets import Static

from arl_tui.app.plain_app import PlainApp
from arl_tui.language import key_for, key_name, later, tr, trn
from arl_tui.palette import STANDARD, Palette, palette_for
from arl_tui.screens.covers import SmallWindowScreen, fits_into
from arl_tui.screens.page import PageScreen, key_cap
from arl_tui.widgets.board import TetrisBoard
from arl_tui.widgets.next_piece import NextPiece
from arl_tui.widgets.stats import Figures, StatsPanel
from core.numerics.clock import Clock, MonotonicClock
from core.tetris.game import Primitive
from core.tetris.practice import Practice

POLL_S = 1 / 30
"""How often the clock is looked at, seconds."""
BESIDE, KEYS_END = 38, 20
"""Columns beside the board, and lines down to the end of what stands there."""

KEYS_HELP = later(
    """\
  [b]← →[/b] or [b]a d[/b]    move
   [b]↑[/b]  or  [b]r[/b]     turn clockwise
   [b]↓[/b]  or [b]space[/b]  drop

  [b]{pause}[/b] pause  [b]{help}[/b] help  [b]{stop}[/b] stop
  [b]{new}[/b] new game

  Full rows disappear. Do not let
  the pile reach the top."""
)
HEADING = later("Practice: play Tetris yourself")
RULES = later(
    "You play the game that the computer plays, with its own four moves. One piece after another falls. Full "
    "rows disappear: the more, the better. A game ends when the pile reaches the top.\n"
)
ROWS = (
    ("←", later("or A: one column to the left")),
    ("→", later("or D: one column to the right")),
    ("↑", later("or W, R: turn clockwise")),
    ("↓", later("or S, Space: drop")),
)
OWN_ROWS = (
    ("pause", later("pause, and go on")),
    ("new", later("a new game")),
    ("help", later("this page")),
    ("stop", later("stop")),
)
"""The program's own keys, by name, and what they do."""
CALL = later("Press {key_space} to go on, {key_stop} to leave")
"""What participants read; the keys of pause, help and stop are those of a session."""


class PracticeHelp(PageScreen):
    """What to do, and all keys."""

    HEADING = HEADING
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("h,f1,space,enter,escape", "back", "Go on", id="tetris-help.back", tooltip="Go on"),
        Binding("q,ctrl+q,ctrl+c", "stop", "Stop", id="tetris-help.stop", tooltip="Leave practice"),
    ]

    def __init__(self, games: int | None) -> None:
        """Prepare; `games` is how many are played, None for no limit."""
        super().__init__()
        self._n_games = games

    def body(self) -> Iterable[Widget]:
        """Return the text."""
        yield Static(tr(RULES))
        rows = [(key, meaning) for key, meaning in ROWS]
        rows += [(key_name(key_for(name)), meaning) for name, meaning in OWN_ROWS]
        yield Static("\n".join(f"  {key_cap(key)}  {tr(meaning)}" for key, meaning in rows))
        if self._n_games is not None:
            yield Static(
                "\n" + trn("One game. Nothing is recorded.", "{n} games. Nothing is recorded.", self._n_games)
            )
        yield Static(tr(CALL), classes="call")

    def action_back(self) -> None:
        """Go on."""
        self.leave(True)

    def action_stop(self) -> None:
        """Leave."""
        self.leave(False)


@dataclass
class Gravity:
    """How many rows a piece has to fall by now: counted by the clock, so that a late timer loses nothing."""

    interval_ns: int
    clock: Clock
    _running_since_ns: int | None = field(default=None, init=False)
    _paid_ns: int = field(default=0, init=False)

    def __post_init__(self) -> None:
        if self.interval_ns <= 0:
            raise ValueError(f"gravity acts every interval_ns > 0 nanoseconds, got {self.interval_ns}")

    @property
    def running(self) -> bool:
        """Whether time counts."""
        return self._running_since_ns is not None

    def start(self) -> None:
        """Let time count from now on; what was left of an interval at the stop is kept."""
        if self._running_since_ns is None:
            self._running_since_ns = self.clock.now_ns() - self._paid_ns

    def stop(self) -> None:
        """Let time not count."""
        if self._running_since_ns is not None:
            self._paid_ns = self.clock.now_ns() - self._running_since_ns
            self._running_since_ns = None

    def restart(self) -> None:
        """Begin a whole interval: a new piece hangs as long as any other."""
        self._paid_ns = 0
        if self._running_since_ns is not None:
            self._running_since_ns = self.clock.now_ns()

    def due(self) -> int:
        """Return how many rows have come due since the last call."""
        if self._running_since_ns is None:
            return 0
        rows, _ = divmod(self.clock.now_ns() - self._running_since_ns, self.interval_ns)
        self._running_since_ns += rows * self.interval_ns
        return rows


class PracticeScreen(Screen[None], inherit_bindings=False):
    """The board, the next piece, the figures, and the keys."""

    BINDING_GROUP_TITLE = "Practice"
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("left,a", "act('left')", "left", id="practice.left", tooltip="Move the piece left"),
        Binding("right,d", "act('right')", "right", id="practice.right", tooltip="Move the piece right"),
        Binding("up,r,w", "act('rotate')", "turn", id="practice.rotate", tooltip="Turn the piece clockwise"),
        Binding("down,space,s", "act('drop')", "drop", id="practice.drop", tooltip="Drop the piece"),
        Binding("p", "pause", "pause", id="practice.pause", tooltip="Stop the game, or go on"),
        Binding("h,f1", "guide", "help", id="practice.help", tooltip="Rules and keys"),
        Binding("n", "new", "new game", id="practice.new", tooltip="Begin a new game"),
        Binding("q,ctrl+q,ctrl+c", "quit_practice", "quit", id="practice.quit", tooltip="Leave practice"),
    ]
    AUTO_FOCUS = None
    ALLOW_SELECT = False
    DEFAULT_CSS = """
    PracticeScreen { align: center middle; background: $background; }
    PracticeScreen > Horizontal { width: auto; height: auto; }
    PracticeScreen Vertical { width: 36; height: auto; margin-left: 2; }
    PracticeScreen NextPiece { width: 100%; }
    PracticeScreen #keys { padding: 1 0 0 0; width: 100%; height: 10; color: $foreground 80%; }
    """

    def __init__(
        self,
        *,
        seed: int = 0,
        rows: int = 20,
        columns: int = 10,
        fall_s: float = 0.6,
        palette: Palette = STANDARD,
        clock: Clock | None = None,
        games: int | None = None,
        explain: bool = False,
    ) -> None:
        """Prepare a game.

        Args:
            seed: of the first game's pieces, >= 0; each new game takes the next one.
            rows: height of the board.
            columns: width of the board.
            fall_s: a piece falls by a row in this time, seconds, > 0.
            palette: colours.
            clock: of gravity; the machine's by default.
            games: leave after so many, >= 1; None until the player leaves.
            explain: show rules and keys first.
        """
        super().__init__()
        self._games, self._explain, self._begun = games, explain, 1
        self.game = Practice(seed, rows=rows, columns=columns)
        """The rules; the screen only shows them."""
        self._seed = seed
        self._size_of_board = (rows, columns)
        self._needed = Size(2 * columns + 2 + BESIDE, max(rows + 2, KEYS_END))
        self._gravity = Gravity(round(fall_s * 1e9), clock or MonotonicClock())
        self._board = TetrisBoard(rows, columns, palette=palette, around=Size(BESIDE + 2, 2))
        self._next = NextPiece(palette=palette)
        self._stats = StatsPanel(later("Practice"), lines_high=2)

    def compose(self) -> ComposeResult:
        """Lay out the board on the left, everything else on the right."""
        with Horizontal():
            yield self._board
            with Vertical():
                yield self._next
                yield self._stats
                yield Static(tr(KEYS_HELP, **self._letters()), id="keys")

    @staticmethod
    def _letters() -> dict[str, str]:
        return {name: key_for(name) for name in ("pause", "help", "new", "stop")}

    def on_mount(self) -> None:
        """Show the game and let time count."""
        self._draw()
        self._gravity.start()
        self.set_interval(POLL_S, self.fall)
        if self._explain:
            self.action_guide()

    def fall(self) -> None:
        """Let gravity act as often as the clock says."""
        rows = self._gravity.due()
        for _ in range(rows):
            self.game.step(None)
        if rows:
            self._draw()

    def action_act(self, primitive: str) -> None:
        """Make one primitive."""
        if self._board.covered:
            return
        pieces = self.game.pieces
        self.game.step(Primitive(primitive))
        if self.game.pieces != pieces:
            self._gravity.restart()
        self._draw()

    def action_pause(self) -> None:
        """Cover the board and stop the clock, or go on."""
        if self.game.over:
            return
        if self._gravity.running:
            self._gravity.stop()
            self._board.cover(tr("PAUSE\n\npress {pause} to go on", pause=key_for("pause")))
        else:
            self._board.uncover()
            self._gravity.start()

    def action_guide(self) -> None:
        """Show rules and keys; the game waits."""
        self._lay_over(PracticeHelp(self._games))

    def action_new(self) -> None:
        """Begin a new game with other pieces; leave after the last one."""
        if self._games is not None and self._begun >= self._games:
            self.action_quit_practice()
            return
        self._begun += 1
        self._seed = (self._seed + 1) % (1 << 63)
        rows, columns = self._size_of_board
        self.game = Practice(self._seed, rows=rows, columns=columns)
        self._board.uncover()
        self._gravity.restart()
        self._gravity.start()
        self._draw()

    def action_quit_practice(self) -> None:
        """Leave."""
        self.dismiss()

    def on_resize(self, event: events.Resize) -> None:
        """Ask for a larger window where the game does not fit; it waits."""
        if not self.is_active or fits_into(self._needed, event.size):
            return
        self._lay_over(SmallWindowScreen(self._needed))

    def _lay_over(self, page: PageScreen) -> None:
        """Show a page while the game waits; leave where it is answered so."""
        went_on = self._gravity.running
        self._gravity.stop()

        def go_on(large: bool | None) -> None:
            if large is False:
                self.action_quit_practice()
            elif went_on:
                self._gravity.start()

        self.app.push_screen(page, go_on)

    def _draw(self) -> None:
        picture = self.game.picture()
        self._board.show(picture)
        self._next.show(picture.counts.next_piece)
        self._stats.show(Figures(lines=picture.counts.lines, pieces=picture.counts.pieces))
        if picture.over and not self._board.covered:
            self._gravity.stop()
            last = self._games is not None and self._begun >= self._games
            over = trn("GAME OVER\n{n} row cleared", "GAME OVER\n{n} rows cleared", picture.counts.lines)
            new, stop = key_for("new"), key_for("stop")
            call = (
                tr("{new} go on", new=new) if last else tr("{new} new game  {stop} stop", new=new, stop=stop)
            )
            self._board.cover(f"{over}\n\n{call}", whole=False)


class PracticeApp(PlainApp[int]):
    """Practice on its own; its result is how many rows the last game has cleared."""

    CSS_PATH = "../app.tcss"
    TITLE = "arl practice"

    def __init__(
        self,
        *,
        seed: int = 0,
        rows: int = 20,
        columns: int = 10,
        fall_s: float = 0.6,
        palette: str = STANDARD.name,
        clock: Clock | None = None,
        games: int | None = None,
        explain: bool = False,
        language: str = "en",
    ) -> None:
        """Prepare a game; the arguments are those of PracticeScreen, the palette by name, and the language of
        the words.

        Raises:
            ValueError: there is no such palette, or the board is too small.
        """
        super().__init__(language=language)
        self.practice = PracticeScreen(
            seed=seed,
            rows=rows,
            columns=columns,
            fall_s=fall_s,
            palette=palette_for(
                palette, self.console.color_system, no_color=self.no_color, theme=self.theme_name
            ),
            clock=clock,
            games=games,
            explain=explain,
        )

    def on_mount(self) -> None:
        """Open the game, and close with it."""
        self.push_screen(self.practice, callback=lambda _result: self.exit(self.practice.game.lines))
