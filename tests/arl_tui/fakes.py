"""Stand-ins for the worker's process and for the disk."""

from collections.abc import Callable

import msgspec

from arl_tui.app.link import FromWorker, ToWorker
from core.configuration.open_table import decode_open_table
from core.events import EpisodeEnded, EpisodeStarted, Event, SessionEnded, StepTaken


class FakeLink:
    """A worker that says what the test tells it to say, and notes what it is told."""

    def __init__(self) -> None:
        self.sent: list[ToWorker] = []
        self.listening = False
        self.closed = False
        self._on_message: Callable[[FromWorker], None] | None = None
        self._on_lost: Callable[[str], None] | None = None

    def listen(self, on_message: Callable[[FromWorker], None], on_lost: Callable[[str], None]) -> None:
        self._on_message, self._on_lost = on_message, on_lost
        self.listening = True

    def stop_listening(self) -> None:
        self.listening = False

    def send(self, message: ToWorker) -> None:
        self.sent.append(msgspec.msgpack.decode(msgspec.msgpack.encode(message), type=ToWorker))

    def close(self, patience_s: float = 2.0) -> None:
        self.closed = True

    def say(self, *messages: FromWorker) -> None:
        """Deliver messages as if the worker had sent them."""
        assert self._on_message is not None
        for message in messages:
            if self.listening:
                # As over the pipe: what cannot be encoded and decoded cannot be said.
                encoded = msgspec.msgpack.encode(message)
                self._on_message(msgspec.msgpack.decode(encoded, type=FromWorker, dec_hook=decode_open_table))

    def die(self, reason: str) -> None:
        """End as a killed process does."""
        assert self._on_lost is not None
        self.listening = False
        self._on_lost(reason)


class ListSink:
    """Keeps events in memory."""

    def __init__(self) -> None:
        self.events: list[Event] = []
        self.failure: OSError | None = None
        self.held_back = 0
        """So many of the last events are not in the file yet."""

    @property
    def recorded(self) -> int:
        return len(self.events)

    @property
    def written(self) -> int:
        return len(self.events) - self.held_back

    def record(self, event: Event) -> None:
        self.events.append(event)


def episode_started(episode: int = 0, *, seed: int = 7) -> EpisodeStarted:
    return EpisodeStarted(
        episode=episode,
        time_ns=0,
        inputs=0,
        episode_seed=seed,
        policy=0,
        form=0,
        w_r=1.0,
        trust=0.25,
        weight=0.25,
        handover=0.0,
    )


def step_taken(
    step: int, *, piece: int = 1, orientation: int = 0, column: int = 0, episode: int = 0
) -> StepTaken:
    return StepTaken(
        episode=episode,
        step=step,
        time_ns=0,
        inputs=0,
        action=column,
        environment_action=column,
        human_action=-1,
        detail={"piece": piece, "orientation": orientation, "column": column},
        reward=0.0,
    )


def episode_ended(episode: int = 0, *, performance: float = 3.0) -> EpisodeEnded:
    return EpisodeEnded(
        episode=episode,
        time_ns=0,
        inputs=0,
        performance=performance,
        steps=2,
        ended="termination",
        agreed=0,
        agreed_worst=0,
        trust=0.25,
        digest="00",
    )


def session_ended(reason: str = "finished") -> SessionEnded:
    return SessionEnded(time_ns=0, inputs=0, reason=reason, weights={}, digest="00")
