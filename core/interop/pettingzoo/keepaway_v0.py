"""The program's Keepaway in PettingZoo's parallel interface: `keepaway_v0.parallel_env()`.

A step goes from one decision to the next. All keepers give an action; only the action of a keeper that has to
decide is used (`infos[keeper]["decides"]`): the others go to the ball or get open by themselves (section 3.3
of the paper). Match, percepts and options are those of `core.keepaway`.
"""

from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from core.interop.pettingzoo.pitch_pictures import pitch_pixels, pitch_text
from core.interop.spaces import keepaway_actions, keepaway_observations
from core.keepaway.decisions import DecisionPlay
from core.keepaway.pitch import CYCLE_S, NO_PLAYER, ONGOING, KeepawayConfig
from core.keepaway.simulator.variables import observe
from core.numerics.streams import stream
from core.plugins import GameError

try:
    from pettingzoo import ParallelEnv
    from pettingzoo.utils import parallel_to_aec
except ImportError as error:  # the extra is not installed
    raise GameError("PettingZoo is not installed: pip install 'arl-tui[pettingzoo]'") from error

LARGEST_SEED = 2**62
By = dict[str, Any]
"""A value for each keeper, by its name."""


def parallel_env(render_mode: str | None = None, **settings: Any) -> "KeepawayEnv":
    """Return the environment; arguments as `KeepawayEnv`."""
    return KeepawayEnv(render_mode, **settings)


def env(render_mode: str | None = None, **settings: Any) -> Any:
    """Return the environment in PettingZoo's turn-based interface (AEC): keepers give actions one by one."""
    return parallel_to_aec(KeepawayEnv(render_mode, **settings))


class KeepawayEnv(ParallelEnv[str, NDArray[np.float64], int]):  # type: ignore[misc]
    """Keepers `keeper_0`, ... keep the ball from takers who play as the benchmark's do.

    A keeper observes its own state variables, as it believes them: float64, metres and degrees, in the order
    of `core.interop.spaces.keepaway_names`. Action 0 holds the ball, k passes to the k-th nearest keeper. The
    reward of a step, the same for all, is the seconds that it took (those before the first decision are no
    step's: `infos[keeper]["cycle"]` counts all, in tenths of a second). The episode ends for all when the
    ball is out or taken; after an hour it is truncated.
    """

    metadata: ClassVar[dict[str, Any]] = {
        "name": "keepaway_v0",
        "render_modes": ["ansi", "rgb_array"],
        "render_fps": 5,
        "is_parallelizable": True,
    }

    def __init__(self, render_mode: str | None = None, **settings: Any) -> None:
        """Take the size of the game.

        Args:
            render_mode: "ansi" for text, "rgb_array" for pictures.
            **settings: fields of `core.keepaway.pitch.KeepawayConfig`: n_keepers, n_takers, length_m, ....

        Raises:
            ValueError: a mode or a setting is none.
            TypeError: a setting has an unknown name.
        """
        if render_mode is not None and render_mode not in self.metadata["render_modes"]:
            raise ValueError(f'render_mode is "ansi", "rgb_array" or None, got {render_mode!r}')
        self.render_mode = render_mode
        self.config = KeepawayConfig(**settings)
        self.possible_agents = [f"keeper_{k}" for k in range(self.config.n_keepers)]
        self.agents: list[str] = []
        self.observation_spaces = {name: keepaway_observations(self.config) for name in self.possible_agents}
        self.action_spaces = {name: keepaway_actions(self.config) for name in self.possible_agents}
        self._rng: np.random.Generator | None = None
        self._play: DecisionPlay | None = None
        self.episode_seed = -1
        """Of the present episode: a session's episode with this seed begins alike."""

    def observation_space(self, agent: str) -> Any:
        """Return what a keeper sees."""
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> Any:
        """Return what a keeper can choose."""
        return self.action_spaces[agent]

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[By, By]:
        """Begin an episode.

        Args:
            seed: of the sequence of episodes; without one the sequence goes on, or begins with a random one.
            options: {"episode_seed": n}, n >= 0, begins the episode of a session with this seed.

        Raises:
            ValueError: in the episode asked for no keeper ever has to decide.
        """
        if seed is not None or self._rng is None:
            root = int(np.random.SeedSequence(seed).generate_state(1)[0])
            self._rng = stream(root, "keepaway_v0")
        chosen = (options or {}).get("episode_seed")
        play = self._begin(int(self._rng.integers(LARGEST_SEED)) if chosen is None else int(chosen))
        while play.keeper == NO_PLAYER:
            if chosen is not None:
                raise ValueError(f"the episode with seed {chosen} ends before a keeper has to decide")
            play = self._begin(int(self._rng.integers(LARGEST_SEED)))
        self._play = play
        self.agents = list(self.possible_agents)
        return self._observations(), self._infos()

    def step(self, actions: dict[str, int]) -> tuple[By, By, By, By, By]:
        """Play to the next decision.

        Args:
            actions: one for each keeper; that of a keeper that does not decide is not used.

        Returns:
            Observations, rewards, terminations, truncations and infos, by the keepers' names.

        Raises:
            ValueError: there is no action for a keeper that has to decide, or it is none; or the episode is
                over.
        """
        if not self.agents or self._play is None:
            raise ValueError("the episode is over: call reset()")
        play, before = self._play, self._play.cycle
        for keeper in np.flatnonzero(play.match.deciding).tolist():
            name = self.possible_agents[keeper]
            action = actions.get(name)
            if action is None or not self.action_spaces[name].contains(action):
                raise ValueError(
                    f"{name} has to decide: {self.action_spaces[name]} is expected, got {action}"
                )
            play.decide(int(action))
        over = play.keeper == NO_PLAYER
        terminated = over and play.ended != ONGOING
        reward = (play.cycle - before) * CYCLE_S
        seen, infos = self._observations(), self._infos()
        names = self.agents
        if over:
            self.agents = []
        return (
            seen,
            dict.fromkeys(names, reward),
            dict.fromkeys(names, terminated),
            dict.fromkeys(names, over and not terminated),
            infos,
        )

    def render(self) -> Any:
        """Return the picture in the mode asked for: text, or pixels of shape (height, width, 3)."""
        if self.render_mode is None or self._play is None:
            return None
        draw = pitch_text if self.render_mode == "ansi" else pitch_pixels
        return draw(self._play.match, self.config)

    def state(self) -> NDArray[np.float64]:
        """Return where ball and players really are: x, y, vx, vy of the ball, then x, y, vx, vy, body, neck
        of each player, keepers first.
        """
        assert self._play is not None, "reset() comes first"
        match = self._play.match
        return np.concatenate([match.ball, match.players.ravel()])

    def close(self) -> None:
        """Do nothing: no window is open."""

    def _begin(self, episode_seed: int) -> DecisionPlay:
        self.episode_seed = episode_seed
        play = DecisionPlay(self.config, episode_seed)
        play.begin()
        return play

    def _observations(self) -> By:
        assert self._play is not None
        match, n_keepers = self._play.match, self.config.n_keepers
        order = np.empty(len(match.players), np.int64)
        seen: By = {}
        for keeper, name in enumerate(self.possible_agents):
            players = match.players if self.config.rules().exact_state else match.seen_players[keeper]
            seen[name] = np.empty(match.variables.shape[1])
            observe(keeper, players, n_keepers, order, seen[name])
        return seen

    def _infos(self) -> By:
        assert self._play is not None
        deciding = self._play.match.deciding if self._play.keeper != NO_PLAYER else ()
        return {
            name: {
                "decides": bool(len(deciding) and deciding[keeper]),
                "cycle": self._play.cycle,
                "episode_seed": self.episode_seed,
            }
            for keeper, name in enumerate(self.possible_agents)
        }
