"""How a learner encodes an observation (`core.learners.encoding`). No numerical library is imported."""

from typing import Annotated

import msgspec

from core.configuration.fields import number


class TileEncoder(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Tiles over the range of each number of an observation, or of all together."""

    tilings: Annotated[int, number("tilings", ge=1, le=64)] = 8
    """Tilings of each number of a box observation. (Sutton & Barto 2018, section 10.1: 8.)"""
    tiles: Annotated[int, number("tiles", ge=1, le=1000)] = 8
    """Tiles across the range of each number. (Sutton & Barto 2018, section 10.1: 8.)"""
    largest: Annotated[float, number(gt=0, le=1e6)] = 3.0
    """Range of a number without bounds: -largest to largest; beyond, it counts as its end. (Our choice.)"""
    joint: bool = False
    """Whether a tile covers a range of all numbers together (Sutton & Barto 2018, section 10.1), or of one
    number alone. Together, tilings x (tiles + 1)^numbers weights are needed for each action."""
