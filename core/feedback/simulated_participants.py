"""Simulated participants by name: one registry, from which experiments and tests take them.

All keep the paper's budget (section 4): at most 5 judgements in an episode, 2 on average where it is long
enough, and about 1 in 10 wrong, unless their name says otherwise.
"""

from collections.abc import Mapping
from types import MappingProxyType

from core.feedback.config import TrainerConfig
from core.feedback.delays import GammaDelay

_PEOPLE = {
    # Judges as a controller far beyond what the learner's features can express.
    "expert": TrainerConfig(mean_presses=2.0),
    # Judges by what meets the eye.
    "lay": TrainerConfig(mean_presses=2.0, knowledge="lay"),
    # Judges the step's immediate effect, whatever comes of it.
    "myopic": TrainerConfig(mean_presses=2.0, knowledge="myopic"),
    # Says nothing where it is hard to tell (B-Pref's skip and equal).
    "hesitant": TrainerConfig(mean_presses=2.0, skip_margin=0.1, equal_margin=0.25),
    # Often presses the wrong key.
    "noisy": TrainerConfig(mean_presses=2.0, mistake_rate=0.3),
    # Presses any key.
    "useless": TrainerConfig(mean_presses=2.0, mistake_rate=0.5),
    # Means the opposite, as reliably as the expert.
    "adversary": TrainerConfig(mean_presses=2.0, mistake_rate=0.9),
    # Makes no mistakes, but presses wrongly when asked to: the paper's instruction, about 1 in 10.
    "instructed": TrainerConfig(mean_presses=2.0, mistake_rate=0.0, deliberate_rate=0.1),
    # Presses several times in a row, as two of the four people in TAMER's logs.
    "bursty": TrainerConfig(mean_presses=2.0, burst_rate=0.75),
    # Presses before the outcome is seen, in a third of the cases.
    "hasty": TrainerConfig(mean_presses=2.0, anticipation_rate=1 / 3),
    # Takes twice as long to press.
    "slow": TrainerConfig(mean_presses=2.0, delay=GammaDelay(2.5, 0.6)),
    # Presses half as often after each 150 watched episodes.
    "tiring": TrainerConfig(mean_presses=2.0, fatigue_half_life_episodes=150.0),
    # Gets up after 300 watched episodes, a fifth of the paper's Fig. 5 as we run it.
    "leaves": TrainerConfig(mean_presses=2.0, stops_after_episodes=300),
}


def persons() -> Mapping[str, TrainerConfig]:
    """Return all simulated participants by name."""
    return MappingProxyType(_PEOPLE)


def person(name: str) -> TrainerConfig:
    """Return one simulated participant.

    Raises:
        ValueError: nobody has this name.
    """
    if name not in _PEOPLE:
        raise ValueError(f"there is no simulated person {name!r}: known are {', '.join(_PEOPLE)}")
    return _PEOPLE[name]
