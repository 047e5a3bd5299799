"""Practice of Keepaway: a participant decides for whichever keeper has the ball. Nothing is recorded."""

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, ClassVar, cast

from textual.binding import Binding, BindingType
from textual.widget import Widget
from textual.widgets import Static

from arl_tui.language import key_for, key_name, later, tr, trn
from arl_tui.screens.page import PageScreen, key_cap
from arl_tui.screens.practice import CALL
from arl_tui.screens.watch import WatchScreen, summary

if TYPE_CHECKING:
    from arl_tui.games.keepaway.playback import Source
    from core.keepaway.practice import KeeperPractice

HEADING = later("Practice: keep the ball yourself")
RULES = later(
    "You play the game that the computer plays. The keepers ([b]K[/]) pass a ball among themselves, and the "
    "takers ([b]T[/]) want it. A game ends when a taker has it, or it leaves the square: the longer you keep "
    "it, the better. You decide for the keeper who has the ball: it holds the ball until you say whom it "
    "passes to.\n"
)
PASS, HOLD = later("pass to {keeper}"), later("hold the ball: press nothing")
ROWS = (
    ("pause", later("pause, and go on")),
    ("help", later("this page")),
    ("stop", later("stop")),
)
"""The program's own keys, by name, and what they do."""
PANEL = later("[b]Practice[/]\n\nGame {game} of {games}")
KEPT = later("Kept {seconds} s")
PAUSED = later("[reverse] PAUSED [/]")
ENDS = (later("ongoing"), later("out"), later("taken"))
"""As `core.keepaway.pitch.END_REASONS`, which a test compares."""
"""What participants read; the keys and marks are those of a session."""


class KeeperHelp(PageScreen):
    """What to do, and all keys."""

    HEADING = HEADING
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("h,f1,space,enter,escape", "back", "Go on", id="practice-help.back", tooltip="Go on"),
        Binding("q,ctrl+q,ctrl+c", "stop", "Stop", id="practice-help.stop", tooltip="Leave practice"),
    ]

    def __init__(self, keepers: int, games: int) -> None:
        """Prepare.

        Args:
            keepers: how many there are.
            games: how many are played.
        """
        super().__init__()
        self._keepers, self._n_games = keepers, games

    def body(self) -> Iterable[Widget]:
        """Return the text."""
        yield Static(tr(RULES))
        rows = [(str(k), tr(PASS, keeper=f"K{k}")) for k in range(1, self._keepers + 1)]
        text = [f"  {key_cap(key)}  {meaning}" for key, meaning in rows]
        yield Static("\n".join([*text, f"       {tr(HOLD)}", ""]))
        yield Static("\n".join(f"  {key_cap(key_for(name))}  {tr(meaning)}" for name, meaning in ROWS) + "\n")
        yield Static(trn("One game. Nothing is recorded.", "{n} games. Nothing is recorded.", self._n_games))
        yield Static(tr(CALL), classes="call")

    def action_back(self) -> None:
        """Go on."""
        self.leave(True)

    def action_stop(self) -> None:
        """Leave."""
        self.leave(False)


class KeeperPracticeScreen(WatchScreen, inherit_bindings=False):
    """The pitch, with keys that pass."""

    BINDING_GROUP_TITLE = "Practice"
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("p,space", "pause", "pause", id="keeper.pause", tooltip="Stand still, or go on"),
        Binding("h,f1", "guide", "help", id="keeper.help", tooltip="Keys and rules"),
        Binding("q,ctrl+q,ctrl+c", "leave", "quit", id="keeper.quit", tooltip="Leave practice"),
        *(
            Binding(str(k), f"pass({k})", f"pass to K{k}", id=f"keeper.pass-{k}", tooltip=f"Pass to K{k}")
            for k in range(1, 10)
        ),
    ]

    def __init__(self, *, keepers: int, games: int, **options: Any) -> None:
        """Prepare an empty pitch.

        Args:
            keepers: how many there are.
            games: leave after so many, >= 1.
            options: of `WatchScreen`: size, speed, palette, clock.
        """
        super().__init__(tr(HEADING), episodes=games, **options)
        passes = " ".join(map(str, range(1, keepers + 1)))
        self.keys = (
            (passes, tr("pass")),
            *((key_name(key_for(name)), tr(name)) for name in ("pause", "help", "stop")),
        )
        self._keepers, self._n_games = keepers, games
        self._practice: KeeperPractice | None = None

    def begin(self, source: "Source") -> None:
        """Explain, and start to play when that has been read."""
        self._practice = cast("KeeperPractice", source)
        super().begin(source)
        self.action_guide()

    def draw(self) -> None:
        """Draw the picture that is due, named as games of a session are."""
        if self.playback is not None:
            self.pitch.title = tr("Game {number}", number=self.playback.picture().episode)
        super().draw()

    def summary(self, ends: list[tuple[float, int]]) -> str:
        """Say in a line how the games went."""
        return summary(ends, unit="game", done="played")

    def action_pass(self, keeper: int) -> None:
        """Wish for a pass; a number that no keeper has does nothing."""
        if self._practice is not None and keeper <= self._keepers:
            self._practice.pass_to(keeper - 1)

    def action_guide(self) -> None:
        """Show rules and keys; time stands still."""
        self._lay_over(
            KeeperHelp(self._keepers, self._n_games), lambda went_on: self._leave_if(went_on is False)
        )

    def panel(self) -> Iterable[str]:
        """Yield what stands beside the pitch, in markup."""
        playback = self.playback
        if playback is None:
            return
        yield tr(PANEL, game=min(len(playback.ends) + 1, self._n_games), games=self._n_games)
        for seconds, end in playback.ends:
            yield f"{tr(KEPT, seconds=f'{seconds:.1f}')}: {tr(ENDS[end])}"
        yield ""
        for k in range(1, self._keepers + 1):
            yield f"{key_cap(str(k))}  {tr(PASS, keeper=f'K{k}')}"
        yield f"     {tr(HOLD)}"
        if playback.paused:
            yield f"\n{tr(PAUSED)}"
