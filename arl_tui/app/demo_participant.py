"""A simulated participant beside the real one: lives in the worker, and suggests key presses to the screen.

The screen makes each suggestion a real key event, so a suggested press takes the same way as a person's.
"""

from typing import TYPE_CHECKING, Any

from arl_tui.app.link import PressSuggested
from core.events import EpisodeStarted, StepTaken
from core.session.protocol import Protocol

if TYPE_CHECKING:
    from core.session.session import Session


class DemoParticipant:
    """Judges each step by an oracle's values, as `protocol.trainer` says."""

    def __init__(self, session: "Session", protocol: Protocol, root_seed: int) -> None:
        # Here, not above: compiled code, and the screen's process imports this module with the worker's.
        from core.feedback.trainers import SimulatedTrainer
        from core.registry import game_of

        game = game_of(protocol)
        self._oracle = game.oracle(protocol)
        self._viewing = game.viewing(protocol)
        self._domain = session.domain
        self._keys = protocol.keys
        self._trainer = SimulatedTrainer(protocol.trainer, root_seed=root_seed)
        self._state: Any = None

    def begin(self, episode: EpisodeStarted) -> None:
        """Note that a watched episode begins."""
        self._state = self._domain.initial(episode.episode_seed)
        self._trainer.watch_episode(episode.episode)

    def watch(self, step: StepTaken, *, shown_ns: int, hidden_ns: int) -> list[PressSuggested]:
        """Return the presses about a step that is about to be shown, in order of time.

        Args:
            step: what was decided.
            shown_ns: when it comes on screen.
            hidden_ns: from when on it can be judged.
        """
        assert self._state is not None, "an episode starts before its first step"
        following = self._domain.transition(self._state, step.action).next_state
        seen = self._viewing.watched(self._state, step.action, following)
        presses = self._trainer.watch(
            step.step,
            self._oracle(self._state),
            step.action,
            shown_ns=shown_ns,
            hidden_ns=hidden_ns,
            attention=seen.attention,
        )
        self._state = following
        good, bad = self._keys.good, self._keys.bad
        return [
            PressSuggested(key=good if press.value > 0 else bad, time_ns=press.time_ns) for press in presses
        ]
