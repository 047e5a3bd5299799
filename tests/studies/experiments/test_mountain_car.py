"""Mountain Car is Gymnasium's, number for number; a trial is what a session with the same inputs would be."""

import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium")

from core.combination.config import EnvironmentOnly
from core.interop.gymnasium.config import GymnasiumConfig
from core.interop.gymnasium.game import GymnasiumDomain
from studies.experiments import mountain_car
from studies.experiments.mountain_car_page import report_page
from studies.experiments.mountain_car_task import MountainCar, teacher
from studies.experiments.mountain_car_trial import quick, run_trial
from studies.experiments.results import read_results
from studies.experiments.run import run_sweep
from studies.experiments.sweep import load_experiment, root_seeds
from tests.contracts.domain_contract import DomainContract

pytestmark = pytest.mark.jit
JOINT = GymnasiumConfig("MountainCar-v0", joint=True)


class TestContract(DomainContract):
    @pytest.fixture(scope="class")
    def domain(self) -> MountainCar:
        return MountainCar(JOINT)

    def random_episode(self, domain, seed):
        # By chance the car is up after thousands of steps; every other one is the teacher's.
        rng, state, trajectory = np.random.default_rng(seed), domain.initial(seed), []
        while not domain.terminal(state):
            up = int(np.argmax(teacher(state)))
            action = up if rng.random() < 0.5 else int(rng.integers(3))
            trajectory.append((state, action))
            state = domain.transition(state, action).next_state
        return [*trajectory, (state, -1)]

    def test_the_teacher_comes_to_the_flag(self, domain: MountainCar) -> None:
        state = domain.initial(0)
        while not domain.terminal(state):
            state = domain.transition(state, int(np.argmax(teacher(state)))).next_state
        assert 80 < state.steps < 200


@pytest.mark.parametrize("seed", range(5))
def test_states_and_tiles_are_those_of_gymnasium_bit_for_bit(seed: int) -> None:
    ours, theirs, env = MountainCar(JOINT), GymnasiumDomain(JOINT), gymnasium.make("MountainCar-v0").unwrapped
    rng = np.random.default_rng(seed)
    state, other = ours.initial(seed), theirs.initial(seed)
    env.reset(seed=seed)
    for _ in range(400):
        assert ours.recorded_state(state) == theirs.recorded_state(other)
        assert (state.position, state.velocity) == tuple(map(float, env.state))
        mine, their = ours.choices(state), theirs.choices(other)
        assert np.array_equal(mine.observation, their.observation)
        assert np.array_equal(mine.feedback_features, their.feedback_features)
        # Now by chance, now upwards, so that walls, the highest speed and the flag are met.
        up = int(np.argmax(teacher(state)))
        action = up if seed % 2 or rng.random() < 0.5 else int(rng.integers(3))
        state, other = ours.transition(state, action).next_state, theirs.transition(other, action).next_state
        env.step(action)
        assert ours.performance(state) == theirs.performance(other)
        assert ours.terminal(state) == theirs.terminal(other)
        if ours.terminal(state):
            break
    assert ours.coder.n_tiles == theirs.coder.n_tiles == 8 * 81


def test_the_left_wall_stops_the_car() -> None:
    ours, env = MountainCar(JOINT), gymnasium.make("MountainCar-v0").unwrapped
    state, stopped = ours.initial(1), False
    env.reset(seed=1)
    for _ in range(500):
        # Pushed along with the motion, and left at rest: the swing to the left becomes wide enough.
        action = 0 if state.velocity <= 0 or state.position > 0.1 else 2
        state = ours.transition(state, action).next_state
        env.step(action)
        stopped |= state.position == -1.2 and state.velocity == 0.0
        assert (state.position, state.velocity) == tuple(map(float, env.state))
        if ours.terminal(state):
            break
    assert stopped


def test_the_teacher_knows_a_good_policy() -> None:
    domain, steps = MountainCar(JOINT), []
    for seed in range(50):
        state = domain.initial(seed)
        while not domain.terminal(state):
            state = domain.transition(state, int(np.argmax(teacher(state)))).next_state
        steps.append(state.steps)
    assert 100 < np.mean(steps) < 135


def test_a_trial_without_a_participant_is_sarsa_by_itself() -> None:
    # One-step targets by hand would be the kernels again: what is held is that nobody is credited, that the
    # weights fall on nobody, and that a scheme that never asks gives the same episodes.
    alone = quick(mountain_car.EXPERIMENT.condition("sarsa").settings)
    rows = run_trial(alone, 900_001)
    assert rows["presses"].sum() == 0
    assert set(rows["w_h"]) == {0.0}
    again = run_trial(quick(mountain_car.trial(EnvironmentOnly(), taught_by=mountain_car.ABSENT)), 900_001)
    assert all(np.array_equal(rows[name], again[name]) for name in rows)


def test_presses_come_at_the_rate_asked_for_and_are_credited() -> None:
    rows = run_trial(quick(mountain_car.trial()), 900_002)
    n_steps = rows["steps"].sum()
    expected = n_steps * mountain_car.TEACHER.press_probability
    # Binomial: allow 4 standard deviations, and a few presses after the end.
    assert abs(rows["presses"].sum() - expected) < 4 * np.sqrt(expected) + 3


@pytest.mark.parametrize("name", [condition.name for condition in mountain_car.EXPERIMENT.conditions])
def test_every_condition_plays_with_negative_performance(name: str) -> None:
    rows = run_trial(quick(mountain_car.EXPERIMENT.condition(name).settings), 900_003)
    assert all(np.isfinite(column).all() for column in rows.values())
    assert (rows["steps"] > 0).all()
    # Trust is a match, however negative the performance is.
    if name.startswith("linear"):
        assert ((rows["trust"] >= 0) & (rows["trust"] <= 1)).all()


def test_the_page_is_made_from_the_files(tmp_path) -> None:
    from concurrent.futures import ThreadPoolExecutor

    experiment = load_experiment("mountain-car")
    with ThreadPoolExecutor(1) as executor:
        run_sweep(experiment, root_seeds(2), tmp_path, executor, quick=True)
    page = report_page(read_results(experiment, tmp_path))
    assert "**In short.** Of 7 claims" in page.text
    assert "What a negative performance does" in page.text
    assert list(page.figures) == ["mountain-car"]
