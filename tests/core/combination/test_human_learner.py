"""What a participant's presses teach, when old ones are no longer kept one by one."""

import numpy as np
import pytest

from core.combination.asking import Question
from core.combination.human_learner import HumanLearner
from core.feedback.credit import GammaDelay
from core.feedback.samples import CreditConfig
from core.learners.human_config import HumanModelConfig, RidgeModel, SgdModel, TileModel
from core.numerics.clock import NS_PER_S
from core.numerics.tile_coding import Tiling

STEPS = 40
"""Of an episode, half a second each, with a pause of ten seconds behind."""


def learner(model: HumanModelConfig, scheme: str) -> HumanLearner:
    tiles = Tiling(n_weights=400, n_tilings=2) if isinstance(model, TileModel) else None
    credit = CreditConfig(delay=GammaDelay(3.0, 0.2, 0.1), scheme=scheme, merge_within_s=0.3)  # type: ignore[arg-type]
    return HumanLearner(credit, model, 3, tiles=tiles)


def lived(who: HumanLearner, n_episodes: int, *, begins: bool, answers: bool) -> list[bytes]:
    """Play episodes in which presses are taken back, some of them in the next episode; return all states."""
    rng = np.random.Generator(np.random.PCG64(1))
    states, held = [], -1
    for episode in range(n_episodes):
        if begins:
            who.episode_begins()
        if held >= 0:
            who.retract(held)  # a key that was held over the end of the last episode
        for step in range(episode * STEPS, (episode + 1) * STEPS):
            now_ns = step * NS_PER_S // 2 + episode * 10 * NS_PER_S
            who.step_shown(step, rng.integers(0, 399, size=3).astype(float), now_ns)
            if step % 5 == 2:
                who.learn_from_press(step, now_ns + NS_PER_S // 10, rng.choice([-1.0, 1.0]))
            if step % STEPS == 30:
                who.retract(step - 3)
                states.append(who.state_bytes() + who.consistency_bytes())
            if answers and step % 19 == 7:
                options = rng.integers(0, 399, size=(2, 3)).astype(float)
                who.learn_from_answer(Question((4, 9), options, 0.5), 9)
        held = (episode + 1) * STEPS - 3 if episode % 2 else -1
        states.append(who.state_bytes() + who.consistency_bytes())
    who.finish(n_episodes * 30 * NS_PER_S)
    return [*states, who.state_bytes() + who.consistency_bytes(), who.weights.tobytes()]


@pytest.mark.parametrize("answers", [False, True])
@pytest.mark.parametrize("scheme", ["individual", "aggregate"])
@pytest.mark.parametrize(
    "model", [SgdModel(), RidgeModel(), TileModel()], ids=lambda model: type(model).__name__
)
def test_what_is_settled_is_learned_to_the_same_bit_and_kept_no_more(model, scheme, answers):
    settling, keeping = learner(model, scheme), learner(model, scheme)
    every_state = lived(settling, 7, begins=True, answers=answers)
    assert every_state == lived(keeping, 7, begins=False, answers=answers)
    assert settling.account == keeping.account
    kept, all_of_them = (len(who._assigner.samples) for who in (settling, keeping))
    assert all_of_them > 3 * kept > 0
