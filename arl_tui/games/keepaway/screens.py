"""What the app has of Keepaway (`arl_tui.games.registry`)."""

from typing import TYPE_CHECKING

import msgspec

from arl_tui.games.registry import GameScreens
from arl_tui.language import later, later_n, tr
from arl_tui.words import JudgingWords, Words
from core.feedback.config import TrainerConfig
from core.keepaway.pitch import CYCLE_S, KeepawayConfig
from core.keepaway.plugin import KEEPAWAY
from core.session.protocol import Protocol, ScreenConfig, SessionConfig
from studies.reaction_time.protocol import Schedule

if TYPE_CHECKING:
    from arl_tui.games.keepaway.panel import KeepawayPanel
    from arl_tui.games.keepaway.renderer import KeepawayRenderer
    from arl_tui.games.keepaway.trial_view import PitchTrialView
    from arl_tui.palette import Palette

WORDS = Words(
    heading=later("Teach a team to keep the ball"),
    welcome=later(
        "You will watch {games} of Keepaway. The keepers ([b]K[/]) pass a ball among themselves, and the "
        "takers ([b]T[/]) "
        "want it. A game ends when a taker has it, or it leaves the square: the longer the keepers keep it, "
        "the better. "
        "They do not know yet how to play well. {practises}You can help them: say what you think of the last "
        "pass, or "
        "of holding the ball too long."
    ),
    rules=later(
        "The keepers (K) pass the ball among themselves; the takers (T) want it. A game ends when a taker "
        "has the "
        "ball or it leaves the square: the longer the keepers keep it, the better. The player with the ball "
        "holds "
        "it or passes it.\n\nTell the team what you think of its last pass, or of holding the ball too "
        "long:\n"
    ),
    practises=later("They practise on their own between games. "),
    performance=later("Seconds the ball was kept"),
    units=later_n("second", "seconds"),
    steps=later("decisions"),
    step=later("option"),
    question=later("What should the keeper do?"),
)
JUDGING = JudgingWords(
    instruction=later(
        "You watch a computer play: three keepers pass the ball among themselves, two takers try to get it. "
        "At one moment "
        "the play stops, and [b]NOW[/] appears below it.\n\n"
        "The ball has reached a keeper:  press {yes}\nThe keepers have lost the ball: press {no}\n\n"
        "Press as soon as you have made up your mind."
    ),
    reminder=later("{no} ball lost\n{yes} ball kept"),
)


class KeepawayScreens(GameScreens):
    """The pitch and the score."""

    name = "keepaway"
    words = WORDS
    judging_module = "arl_tui.games.keepaway.judging"
    judging = JUDGING

    def trial_view(self, prepared: bytes, schedule: Schedule, palette: "Palette") -> "PitchTrialView":
        """Return the pitch on which a possession ends in each trial."""
        from arl_tui.games.keepaway.judging import Clip, cycle_ms
        from arl_tui.games.keepaway.trial_view import PitchTrialView

        return PitchTrialView(msgspec.json.decode(prepared, type=list[Clip]), palette, cycle_ms(schedule))

    def picture_ms(self, screen: ScreenConfig) -> float:
        """Return how long a cycle is shown."""
        return CYCLE_S * 1000.0 / screen.speed

    def slower(self, screen: ScreenConfig) -> str:
        """Return the pace and how it is made slower."""
        return f"[screen] speed is {screen.speed:g}: less is slower"

    def demo(self, trainer: TrainerConfig | None) -> Protocol:
        """Return five games at their own speed with practice between; the participant presses often."""
        return msgspec.structs.replace(
            KEEPAWAY,
            name="demo",
            screen=ScreenConfig(speed=1.0, count_down_s=1),
            session=SessionConfig(episodes=5, unseen_between=100, watched_steps=300, unseen_steps=3000),
            trainer=msgspec.structs.replace(
                trainer or KEEPAWAY.trainer,
                press_probability=0.8,
                max_presses=KEEPAWAY.trainer.max_presses,
                mean_presses=KEEPAWAY.trainer.mean_presses,
            ),
        )

    def option(self, detail: dict[str, int], protocol: Protocol) -> str:
        """Return whom the keeper would pass to."""
        if detail["target"] < 0:
            return tr("hold the ball")
        return tr("pass to {keeper}", keeper=f"K{detail['target'] + 1}")

    def renderer(self, protocol: Protocol) -> "KeepawayRenderer":
        """Return what draws the match cycle by cycle; compiled code comes with it."""
        from arl_tui.games.keepaway.renderer import KeepawayRenderer

        assert isinstance(protocol.domain, KeepawayConfig), "a protocol of Keepaway"
        return KeepawayRenderer(protocol.domain, protocol.screen.speed)

    def panel(self, protocol: Protocol, palette: "Palette") -> "KeepawayPanel":
        """Return the pitch and what stands beside it."""
        from arl_tui.games.keepaway.panel import KeepawayPanel

        return KeepawayPanel(protocol, palette)


SCREENS = KeepawayScreens()
