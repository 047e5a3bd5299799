"""Numbers that overflow in a session end it with the reason, and the recording stays readable."""

import gymnasium
import msgspec
import numpy as np
import pytest

from core.events import SessionEnded
from core.feedback.samples import FeedbackSample
from core.interop.gymnasium.config import GymnasiumConfig
from core.learners.human_config import RidgeModel, SgdModel, TileModel
from core.learners.human_reward import HumanRewardModel
from core.numerics.finite import DivergedError, check_numbers
from core.plugins import GameError
from core.recording.reader import read_recording
from core.session.protocol import Protocol, SessionConfig
from core.session.protocol_reading import load_protocol
from studies.demo import simulate_session
from tests.core.sessions import TALKATIVE

# Of code that is not compiled.
pytestmark = pytest.mark.filterwarnings("ignore:overflow encountered", "ignore:invalid value encountered")


def psi(numbers, action):
    return [1e200 * numbers[0], 1.0 * action]


class NoNumber(gymnasium.Wrapper):
    """Gives a reward that is no number, later than the steps that are tried before a session."""

    def reset(self, **options):
        self.steps = 0
        return self.env.reset(**options)

    def step(self, action):
        self.steps += 1
        seen, _, _, truncated, facts = self.env.step(action)
        return seen, (np.nan if self.steps > 25 else 1.0), False, truncated, facts


def no_number(render_mode=None):
    return NoNumber(gymnasium.make("CartPole-v1"))


@pytest.mark.parametrize(
    ("domain", "model", "error", "told"),
    [
        (
            {"psi": f"{__name__}:psi"},
            RidgeModel(),
            DivergedError,
            r"human model, with features up to \d\S+e\+19",
        ),
        ({"psi": f"{__name__}:psi"}, SgdModel(step_size=0.01), DivergedError, "has overflowed"),
        (
            {"env": f"{__name__}:no_number"},
            TileModel(),
            GameError,
            "no_number gave the reward nan for action",
        ),
    ],
    ids=["ridge", "sgd", "reward"],
)
def test_a_session_that_overflows_ends_with_the_reason_and_can_be_read(tmp_path, domain, model, error, told):
    usual = load_protocol(None, game="gymnasium")
    protocol: Protocol = msgspec.structs.replace(
        usual,
        domain=GymnasiumConfig(**domain),
        session=SessionConfig(episodes=2, unseen_between=0, watched_steps=40, unseen_steps=40),
        agent=msgspec.structs.replace(usual.agent, human_model=model),
        trainer=TALKATIVE,
    )
    with pytest.raises(error, match=told):
        simulate_session(protocol, 3, tmp_path / "s.jsonl", software={})
    recording = read_recording(tmp_path / "s.jsonl")
    assert recording.events
    assert not recording.complete


def test_the_model_of_a_standardised_gradient_does_not_forget_in_silence():
    model = HumanRewardModel(SgdModel(standardise=True), 2)
    model.add(FeedbackSample(np.array([0.0, 1.0]), 1.0, 1.0, 0, (0,)))
    with pytest.raises(DivergedError, match=r"features up to 1e\+200 of step 1"):
        model.add(FeedbackSample(np.array([1e200, 1.0]), 1.0, 1.0, 1, (1,)))


def test_no_number_that_json_cannot_say_reaches_a_recording():
    ended = SessionEnded(time_ns=1, inputs=0, reason="finished", weights={"human": [0.5]}, digest="")
    check_numbers(ended)
    for bad in (np.nan, np.inf):
        with pytest.raises(DivergedError, match="actor of SessionEnded is no finite number"):
            check_numbers(
                msgspec.structs.replace(ended, weights={"human": [0.5], "actor": [0.0, float(bad)]})
            )
