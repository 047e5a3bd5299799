"""An experiment of nothing but numbers, for tests of the runner."""

import time

import msgspec
import numpy as np

from core.numerics.streams import stream
from studies.experiments.sweep import Condition, Experiment


class Tiny(msgspec.Struct, frozen=True):
    mean: float
    places: tuple[int, ...] = (1, 2)
    episodes: int = 6
    seconds: float = 0.0
    fails: bool = False


def trial(settings: Tiny, root_seed: int):
    time.sleep(settings.seconds)
    if settings.fails:
        raise ArithmeticError("this condition cannot be played")
    scores = stream(root_seed, "scores").normal(settings.mean, 1.0, size=settings.episodes)
    return {"score": scores, "count": np.arange(float(settings.episodes))}


def quick(settings: Tiny) -> Tiny:
    return msgspec.structs.replace(settings, episodes=2)


EXPERIMENT = Experiment(
    name="tests.studies.tiny_experiment",
    title="Tiny",
    conditions=(Condition("low", "low", Tiny(0.0)), Condition("high", "high", Tiny(3.0, seconds=0.05))),
    trial=trial,
    quick=quick,
)
