"""Simulated participants beside the real ones: in the worker, they suggest key presses to the screen.

The screen makes each suggestion a real key event, so a suggested press takes the same way as a participant's.
"""

from typing import TYPE_CHECKING, Any

from arl_tui.app.link import PressSuggested
from core.events import EpisodeStarted, QuestionPosed, StepTaken
from core.numerics.clock import NS_PER_S
from core.session.protocol import Protocol

if TYPE_CHECKING:
    from core.session.session import Session


class DemoParticipant:
    """Judges each step by an oracle's values, as `protocol.trainer` says; of several participants all of
    them.
    """

    def __init__(self, session: "Session", protocol: Protocol, root_seed: int) -> None:
        # Here, not above: compiled code, and the screen's process imports this module with the worker's.
        from core.registry import game_of
        from studies.demo import simulated_people

        self._people = simulated_people(protocol, root_seed)
        self._viewing = game_of(protocol).viewing(protocol)
        self._domain = session.domain
        self._asking = protocol.agent.asking
        self._state: Any = None

    def begin(self, episode: EpisodeStarted) -> None:
        """Note that a watched episode begins."""
        self._state = self._domain.initial(episode.episode_seed)
        for parts in self._people:
            parts.trainer.watch_episode(episode.episode)

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
        suggested = []
        for parts in self._people:
            presses = parts.trainer.watch(
                step.step,
                parts.oracle(self._state),
                step.action,
                shown_ns=shown_ns,
                hidden_ns=hidden_ns,
                attention=seen.attention,
            )
            keys = parts.gate.config
            suggested += [
                PressSuggested(key=keys.key_of(each.value), time_ns=each.time_ns) for each in presses
            ]
        self._state = following
        return sorted(suggested, key=lambda each: each.time_ns)

    def answer(self, posed: QuestionPosed, *, shown_ns: int) -> PressSuggested:
        """Return the press that answers a question which is about to be shown at `shown_ns`.

        Of several participants the first one answers.
        """
        assert self._state is not None, "an episode starts before its first question"
        first = self._people[0]
        chosen = first.trainer.answer(posed.step, first.oracle(self._state), posed.options)
        key = self._asking.none_key if chosen is None else self._asking.keys[posed.options.index(chosen)]
        return PressSuggested(
            key=key, time_ns=shown_ns + round(first.trainer.answer_delay_s(posed.step) * NS_PER_S)
        )
