"""Minari data sets of a folder of data: one per game, an episode per watched game.

The games are played again from their seeds and the recorded actions, which gives the observations; where this
program's game differs from the recorded one, nothing is exported. Minari's infos hold one value per step, so
they say the credited feedback; the presses themselves lie beside the data as a table.
"""

import json
import math
import os
import re
import warnings
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from core.domain import Domain
from core.events import EpisodeStarted, StepTaken
from core.interop.gymnasium.action import EnvAction
from core.interop.gymnasium.config import GymnasiumConfig
from core.keepaway.pitch import KeepawayConfig
from core.plugins import GameError
from core.recording.reader import Recording, RecordingError, read_recording
from core.registry import game_of
from core.session.protocol import Protocol
from core.session.protocol_reading import protocol_from
from core.system.private_files import make_private_folder
from core.tetris.action import PlacedPiece
from core.tetris.config import TetrisConfig
from studies.exports.columns import codebook
from studies.exports.event_rows import press_rows, step_rows
from studies.exports.event_tables import PRESSES
from studies.exports.session_rows import SessionRows
from studies.exports.sources import Source, Trouble, find_sources
from studies.exports.tidy import CsvFile, ExportError, TableFile

NAMESPACE = "arl"
SIDECAR = "presses.csv"
FOLDER_VARIABLE = "MINARI_DATASETS_PATH"
"""Environment variable that tells Minari where data sets lie."""


class NotReplayedError(ValueError):
    """A session's games cannot be played again; the message says why."""


@dataclass(slots=True)
class MinariExport:
    """What came of it."""

    episodes: dict[str, int] = field(default_factory=dict)
    """Episodes of each data set, by its id."""
    left_out: list[Trouble] = field(default_factory=list)
    damaged: list[Trouble] = field(default_factory=list)


@dataclass(slots=True)
class Played:
    """One game as arrays over its T steps."""

    observations: Any
    """T + 1 of them: a list for each part of an observation."""
    actions: Any
    rewards: list[float]
    terminated: bool
    infos: dict[str, Any]
    """T + 1 of each: the first is of the beginning, the next of the first step."""
    about: dict[str, Any]
    """Whose game it is."""


def export_minari(place: Path, into: Path) -> MinariExport:
    """Write the data sets `arl/NAME-v0` of the recordings in a folder.

    Args:
        place: a folder of data, or one recording.
        into: a new or an empty folder: Minari finds the data sets there by `MINARI_DATASETS_PATH`.

    Raises:
        ExportError: `into` is not empty, minari is missing, or there is nothing to export.
        OSError: something cannot be read or written.
    """
    if into.exists() and any(into.iterdir()):
        raise ExportError(f"{into} is not empty: name a new folder")
    sources = list(find_sources(place))
    make_private_folder(into)
    result = MinariExport()
    with _minari_in(into) as minari, ExitStack() as stack:
        sets = _Sets(minari, into, stack, result)
        for source in sources:
            try:
                sets.add(source)
            except RecordingError as error:
                result.damaged.append(Trouble(source.path, str(error)))
            except (NotReplayedError, GameError) as error:
                result.left_out.append(Trouble(source.path, str(error)))
    if not result.episodes:
        if not any(into.iterdir()):
            into.rmdir()
        reasons = "; ".join(str(trouble) for trouble in (*result.damaged, *result.left_out)[:3])
        raise ExportError(f"{place}: no game could be exported. {reasons}".rstrip())
    return result


@contextmanager
def _minari_in(folder: Path) -> Iterator[Any]:
    """Import Minari and let it write in a folder."""
    try:
        import minari
    except ImportError as error:
        raise ExportError("Minari data sets need minari: pip install 'arl-tui[minari]'") from error
    before = os.environ.get(FOLDER_VARIABLE)
    os.environ[FOLDER_VARIABLE] = str(folder.absolute())
    try:
        with warnings.catch_warnings():
            # It misses an environment and a link to code, which recordings of people do not have.
            warnings.filterwarnings("ignore", module=r"minari\.")
            yield minari
    finally:
        del os.environ[FOLDER_VARIABLE]
        if before is not None:
            os.environ[FOLDER_VARIABLE] = before


class _Sets:
    """The data sets that are being written, by their ids."""

    def __init__(self, minari: Any, into: Path, stack: ExitStack, result: MinariExport) -> None:
        self._minari = minari
        self._into = into
        self._stack = stack
        self._result = result
        self._sets: dict[str, Any] = {}
        self._sidecars: dict[str, TableFile] = {}

    def add(self, source: Source) -> None:
        if source.kind != "recording":
            raise NotReplayedError("no recording of a game")
        recording = read_recording(source.path)
        if recording.header.origin == "imported":
            raise NotReplayedError("imported: what the agent did is not in it")
        session = SessionRows(recording, source.session)
        protocol = protocol_from(recording.header.protocol)
        name = f"{NAMESPACE}/{_variant(protocol)}-v0"
        # All games first: a session is exported as a whole or not at all.
        for played in list(played_games(recording, session, protocol)):
            self._append(name, protocol, played)
        if name in self._sidecars:
            for row in press_rows(session):
                self._sidecars[name].add(PRESSES.checked(row))

    def _append(self, name: str, protocol: Protocol, played: Played) -> None:
        from minari.data_collector import EpisodeBuffer

        n_steps, number = len(played.rewards), self._result.episodes.get(name, 0)
        last = [False] * (n_steps - 1)
        buffer = EpisodeBuffer(
            id=number,
            observations=played.observations,
            actions=played.actions,
            rewards=played.rewards,
            terminations=[*last, played.terminated],
            truncations=[*last, not played.terminated],
            infos=played.infos,
        )
        if name in self._sets:
            self._sets[name].storage.update_episodes([buffer])
        else:
            self._sets[name] = self._create(name, protocol, buffer)
        self._sets[name].storage.update_episode_metadata([played.about], [number])
        self._result.episodes[name] = number + 1

    def _create(self, name: str, protocol: Protocol, buffer: Any) -> Any:
        observations, actions = _spaces(protocol)
        created = self._minari.utils.create_dataset_from_buffers(
            dataset_id=name,
            buffer=[buffer],
            observation_space=observations,
            action_space=actions,
            algorithm_name="arl-tui session",
            description=DESCRIPTION,
            data_format="arrow",
        )
        folder = self._into / name
        self._sidecars[name] = self._stack.enter_context(CsvFile(folder / SIDECAR, PRESSES))
        (folder / "presses.codebook.json").write_text(
            json.dumps(codebook([PRESSES]), indent=2, ensure_ascii=False) + "\n", encoding="utf-8"
        )
        return created


DESCRIPTION = (
    "Games of an agent that a participant watched and judged by key presses. infos: feedback = sum of value "
    "times share of the presses credited to a step; n_presses = how many; trust and weight of the "
    "participant in this game (NaN where not recorded); feedback_features = psi(s, a) of what was done. "
    "infos[t + 1] belongs to actions[t]. presses.csv holds the raw presses; session, game and step_index in "
    "it and in the episodes' metadata say what belongs together."
)


def played_games(recording: Recording, session: SessionRows, protocol: Protocol) -> Iterator[Played]:
    """Yield each watched game of a session that has steps.

    Args:
        recording: a session that was played, not imported.
        session: the same, looked up.
        protocol: of the session.

    Raises:
        NotReplayedError: the game now plays otherwise than recorded.
    """
    domain = game_of(protocol).domain(protocol)
    rows = {row["step_index"]: row for row in step_rows(session)}
    for number, started in enumerate(session.started, start=1):
        steps = [taken for step, taken in session.steps.items() if session.places[step].game == number]
        if steps:
            yield _played(domain, started, steps, _Context(protocol, session, rows, number))


@dataclass(frozen=True, slots=True)
class _Context:
    protocol: Protocol
    session: SessionRows
    rows: Mapping[Any, Mapping[str, Any]]
    number: int


def _played(
    domain: Domain[Any], started: EpisodeStarted, steps: list[StepTaken], context: _Context
) -> Played:
    state = domain.initial(started.episode_seed)
    states, features = [state], []
    for taken in steps:
        if domain.action_record(state, taken.action).plain() != taken.detail:
            raise NotReplayedError(
                f"step {taken.step} comes out otherwise than recorded: the game has changed since. Export it "
                "with the version of this program that is named in its header "
                f"({context.session.recording.header.software})"
            )
        features.append(domain.choices(state).feedback_features[taken.action])
        state = domain.transition(state, taken.action).next_state
        states.append(state)
    rows = [context.rows[taken.step] for taken in steps]
    n_steps = len(steps)
    first = np.full(features[0].shape, np.nan)
    trust = math.nan if started.trust is None else started.trust
    return Played(
        observations=_observations(context.protocol, states, domain),
        actions=_actions(context.protocol, steps),
        rewards=[taken.reward for taken in steps],
        terminated=bool(domain.terminal(state)),
        infos={
            # Minari's loader reads one number per step from lists only, not from arrays of one dimension.
            "feedback": [0.0, *(row["feedback"] for row in rows)],
            "n_presses": [0, *(row["presses_credited"] for row in rows)],
            "trust": [trust] * (n_steps + 1),
            "weight": [started.weight] * (n_steps + 1),
            "step_index": [-1, *(taken.step for taken in steps)],
            "feedback_features": np.array([first, *features], dtype=np.float64),
        },
        about={
            name: context.session.keys[name] or ""
            for name in ("participant", "session", "condition", "origin")
        }
        | {"game": context.number, "episode_seed": started.episode_seed},
    )


def _variant(protocol: Protocol) -> str:
    """Return the name of the data set of a protocol's game: one for each shape of observation."""
    match protocol.domain:
        case TetrisConfig(rows=rows, columns=columns):
            return f"tetris-{rows}x{columns}"
        case KeepawayConfig(n_keepers=keepers, n_takers=takers):
            return f"keepaway-{keepers}v{takers}"
        case GymnasiumConfig(env=env):
            # An id of Minari has one namespace and letters, digits, "-" and "_"; the version follows.
            return "gymnasium-" + re.sub(r"[^0-9A-Za-z_-]+", "-", env).strip("-")
        case _:
            raise NotReplayedError(f"there is no Minari data set of the game {protocol.game}")


def _spaces(protocol: Protocol) -> tuple[Any, Any]:
    """Return the spaces of observations and actions, Gymnasium's."""
    from core.interop import spaces

    match protocol.domain:
        case TetrisConfig() as board:
            return spaces.tetris_observations(board), spaces.tetris_placements(board)
        case KeepawayConfig() as pitch:
            return spaces.keepaway_observations(pitch), spaces.keepaway_actions(pitch)
        case GymnasiumConfig():
            domain: Any = game_of(protocol).domain(protocol)
            return domain.env.observation_space, domain.env.action_space
        case _:
            raise NotReplayedError(f"there is no Minari data set of the game {protocol.game}")


def _observations(protocol: Protocol, states: list[Any], domain: Any) -> Any:
    """Return what is seen in each state: a board and its piece, the deciding keeper's variables, or what the
    environment gave.
    """
    if isinstance(protocol.domain, TetrisConfig):
        from core.interop.spaces import tetris_observation

        seen = [tetris_observation(domain, state) for state in states]
        return {part: [one[part] for one in seen] for part in ("board", "piece")}
    if isinstance(protocol.domain, GymnasiumConfig):
        return [state.given for state in states]
    return [np.asarray(state.variables, dtype=np.float64) for state in states]


def _actions(protocol: Protocol, steps: list[StepTaken]) -> list[Any]:
    if isinstance(protocol.domain, TetrisConfig):
        return [np.array(PlacedPiece.of(taken).place) for taken in steps]
    if isinstance(protocol.domain, GymnasiumConfig):
        return [EnvAction.of(taken).action for taken in steps]
    return [taken.action for taken in steps]
