"""What a task of Gymnasium is set up by. Gymnasium is not imported here."""

from typing import Annotated

import msgspec

from core.configuration.fields import number
from core.plugins import DomainConfig


class GymnasiumConfig(msgspec.Struct, DomainConfig, frozen=True, forbid_unknown_fields=True, tag="gymnasium"):
    """A Gymnasium environment with discrete actions and box or discrete observations."""

    env: str = "CartPole-v1"
    """Its id, as `gymnasium.make` takes it, or `module:function` of a factory of your own: it is called
    without arguments, and with `render_mode="rgb_array"` where the environment is shown."""
    tilings: Annotated[int, number("tilings", ge=1, le=64)] = 8
    """Tilings of each number of a box observation; of all numbers together where `joint` is on. (Sutton &
    Barto 2018, section 10.1: 8.)"""
    tiles: Annotated[int, number("tiles", ge=1, le=1000)] = 8
    """Tiles across the range of each number. (Sutton & Barto 2018, section 10.1: 8.)"""
    largest: Annotated[float, number(gt=0, le=1e6)] = 3.0
    """Range of a number without bounds: -largest to largest; beyond, it counts as its end. (Our choice.)"""
    joint: bool = False
    """Whether a tile covers a range of all numbers together (Sutton & Barto 2018, section 10.1), or of one
    number alone. Together, tilings x (tiles + 1)^numbers weights are needed for each action."""
    phi: str = ""
    """`module:function` of your own: (observation) -> numbers from 0 to 1, which are seen and tiled in place
    of the observation's. With it an observation may be anything. Empty: the observation's own numbers."""
    psi: str = ""
    """`module:function` of your own: (numbers, action) -> features from which the human model predicts
    feedback; the numbers are those of `phi`, or of the observation. The human model is then of type ridge or
    sgd. Empty: the learner's tiles, for a human model of type tiles."""
