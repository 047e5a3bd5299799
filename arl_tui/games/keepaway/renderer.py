"""From a session's outputs to pictures of the pitch: the match is played again, decision by decision.

A decision's first picture shows the cycle in which it is made; the last picture before the next decision, or
before the end, is the one a cycle earlier. So a hold has one picture and a pass in flight belongs to the
passer's step.
"""

import functools
import itertools
from collections import deque
from typing import TYPE_CHECKING

import msgspec

from arl_tui.games.rendering import Place, TickView
from core.events import EpisodeStarted, StepTaken
from core.keepaway.action import ChosenOption
from core.keepaway.picture import PitchFrame
from core.keepaway.pitch import CYCLE_NS, NO_PLAYER, KeepawayConfig

if TYPE_CHECKING:
    from core.keepaway.simulator.match import Match


OPTIONS_REMEMBERED = 128
"""About ten seconds of the game's time, if nobody passes."""


class KeepawayRenderer:
    """Follows the session's episodes; knows of them only seeds and options."""

    def __init__(self, config: KeepawayConfig, speed: float) -> None:
        """Prepare.

        Args:
            config: size of the game, and what players see.
            speed: simulated seconds per second.
        """
        self.tick_ns = round(CYCLE_NS / speed)
        """How long a cycle is shown."""
        # Here, not above: compiled code comes with them, and the screen's process imports this module.
        from core.keepaway.decisions import DecisionPlay
        from core.keepaway.frame_maker import FrameMaker

        self._new_play = functools.partial(DecisionPlay, config)
        self._new_frame_maker = functools.partial(FrameMaker, config)
        self._episodes = 0
        self._play = self._new_play(0)
        self._frame_maker = self._new_frame_maker()
        self._now = self._look(self._play.match)
        self._options: deque[tuple[int, Place]] = deque(maxlen=OPTIONS_REMEMBERED)

    @property
    def picture(self) -> PitchFrame:
        """The picture of the moment in which the match stands still."""
        return self._now

    @property
    def receivers(self) -> tuple[int, ...]:
        """Keepers to whom the one who decides can pass, nearest first as it sees them: those of options 1, 2,
        ...
        """
        order = self._play.match.order[max(self._play.keeper, 0)]
        return tuple(int(keeper) for keeper in order[1:])

    def could_be(self, step: StepTaken) -> bool:
        """Return whether a recorded step can be the next one: the same keeper decides, and sees the same."""
        same_keeper = self._play.keeper == ChosenOption.of(step).keeper
        return same_keeper and (step.state is None or self._play.variables.tolist() == step.state)

    def begin(self, episode: EpisodeStarted) -> tuple[TickView, ...]:
        """Return the pictures from the kick-off to the cycle before the first decision."""
        self._episodes += 1
        self._play = self._new_play(episode.episode_seed)
        self._frame_maker = self._new_frame_maker()
        pictures = [self._look(self._play.match)]
        self._play.begin(lambda match: pictures.append(self._look(match)))
        return self._ticks(pictures)

    def act(self, step: StepTaken) -> tuple[TickView, ...]:
        """Return the pictures from a decision to the cycle before the next one."""
        chosen = ChosenOption.of(step)
        keeper, target = chosen.keeper, chosen.target
        self._options.append((step.step, ((keeper, target),)))
        pictures = [self._now]
        self._play.decide(step.action, lambda match: pictures.append(self._look(match)))
        shown = [msgspec.structs.replace(picture, decider=keeper, target=target) for picture in pictures[:-1]]
        return self._ticks([*shown, pictures[-1]])

    def judged_after_ns(self, n_ticks: int) -> int:
        """Return one cycle: then an option is seen to have been chosen."""
        return self.tick_ns

    def place_of(self, step: int) -> Place:
        """Return who chose an option, and who was passed to."""
        return next((place for known, place in reversed(self._options) if known == step), ())

    def place_of_option(self, detail: dict[str, int]) -> Place:
        """Return who has the ball, and who would be passed to."""
        return ((detail["keeper"], detail["target"]),)

    def _ticks(self, pictures: list[PitchFrame]) -> tuple[TickView, ...]:
        """Return all but the last picture, which belongs to what comes now, each with the one after it."""
        self._now = pictures[-1]
        return tuple(TickView(view, ahead) for view, ahead in itertools.pairwise(pictures))

    def _look(self, match: "Match") -> PitchFrame:
        picture = self._frame_maker.look(match)
        return msgspec.structs.replace(
            picture, episode=max(1, self._episodes), decider=NO_PLAYER, target=NO_PLAYER
        )
