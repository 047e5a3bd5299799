"""What a task of Gymnasium is set up by. Gymnasium is not imported here."""

from typing import Annotated, ClassVar

import msgspec

from core.configuration.fields import number
from core.learners.encoder_config import TileEncoder
from core.plugins import DomainConfig


class GymnasiumConfig(msgspec.Struct, DomainConfig, frozen=True, forbid_unknown_fields=True, tag="gymnasium"):
    """A Gymnasium environment with discrete actions and box or discrete observations."""

    env: str = "CartPole-v1"
    """Its id, as `gymnasium.make` takes it, or `module:function` of a factory of your own: it is called
    without arguments, and with `render_mode="rgb_array"` where the environment is shown."""
    LATER: ClassVar[frozenset[str]] = frozenset({"phi", "psi", "task", "actions"})
    """Settings that came after version 0.2: at their defaults they are not written to recordings."""
    OLD: ClassVar[frozenset[str]] = frozenset({"tilings", "tiles", "largest", "joint"})

    tilings: Annotated[int, number("tilings", ge=1, le=64)] = 8
    """Old place of `learner.encoder.tilings`. Tilings of each number of a box observation; of all numbers
    together where `joint` is on. (Sutton & Barto 2018, section 10.1: 8.)"""
    tiles: Annotated[int, number("tiles", ge=1, le=1000)] = 8
    """Old place of `learner.encoder.tiles`. Tiles across the range of each number. (Sutton & Barto 2018,
    section 10.1: 8.)"""
    largest: Annotated[float, number(gt=0, le=1e6)] = 3.0
    """Old place of `learner.encoder.largest`. Range of a number without bounds: -largest to largest; beyond,
    it counts as its end. (Our choice.)"""
    joint: bool = False
    """As `learner.encoder.joint`. Whether a tile covers a range of all numbers together (Sutton & Barto 2018,
    section 10.1), or of one number alone. Together, tilings x (tiles + 1)^numbers weights are needed for each
    action."""
    phi: str = ""
    """`module:function` of your own: (observation) -> numbers from 0 to 1, which are seen and tiled in place
    of the observation's. With it an observation may be anything. Empty: the observation's own numbers."""
    psi: str = ""
    """`module:function` of your own: (numbers, action) -> features from which the human model predicts
    feedback; the numbers are those of `phi`, or of the observation. The human model is then of type ridge or
    sgd. Empty: the learner's tiles, for a human model of type tiles."""
    task: str = ""
    """What participants are told that the computer tries to do, at most 60 characters: "walk to the lamp".
    Empty: the program's own words for the environments of Gymnasium that it knows, and only "a task" for
    others."""
    actions: tuple[str, ...] = ()
    """What participants read of each action, in the order of their numbers, at most 18 characters each:
    ["go left", "go right"]. Empty: the program's own words for the environments of Gymnasium that it knows,
    and numbers for others."""


def with_encoder(config: GymnasiumConfig, encoder: TileEncoder | None) -> GymnasiumConfig:
    """Return the configuration with the tiles of the learner's encoder; the old place holds where it was
    used.

    Raises:
        ValueError: both places say something, and not the same.
    """
    usual, old = (
        TileEncoder(),
        TileEncoder(tilings=config.tilings, tiles=config.tiles, largest=config.largest, joint=config.joint),
    )
    if encoder is None or encoder in (usual, old):
        return config
    if old != usual:
        raise ValueError(
            f"[domain] tilings, tiles, largest, joint are {_numbers(old)}, those of [learner.encoder] are "
            f"{_numbers(encoder)}: say them in [learner.encoder] alone"
        )
    return _with(config, encoder)


def _with(config: GymnasiumConfig, encoder: TileEncoder) -> GymnasiumConfig:
    return msgspec.structs.replace(
        config,
        tilings=encoder.tilings,
        tiles=encoder.tiles,
        largest=encoder.largest,
        joint=encoder.joint,
    )


def _numbers(encoder: TileEncoder) -> str:
    return f"{encoder.tilings}, {encoder.tiles}, {encoder.largest:g}, {str(encoder.joint).lower()}"
