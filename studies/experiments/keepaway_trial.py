"""One trial in Keepaway: keepers learn by Sarsa while a simulated participant watches every episode."""

import msgspec
import numpy as np

from core.feedback.delays import Density, GammaDelay, one_density
from core.feedback.trainers import draw_delay_s
from core.keepaway.arl_autoplay import ArlAutoplay, ArlKeepawayConfig
from core.numerics.arrays import Floats
from core.numerics.clock import S_PER_HOUR
from core.numerics.streams import stream
from studies.reaction_time.families import SHIFTED_GAMMA, fit_family
from studies.reaction_time.sample import sample


class KeepawayTrial(msgspec.Struct, frozen=True, kw_only=True):
    """All that decides a trial but its root seed."""

    play: ArlKeepawayConfig = ArlKeepawayConfig()
    hours: float = 10.0
    """Simulated hours of play; the trial ends with the episode that reaches them. Pauses do not count."""
    calibration_trials: int = 0
    """> 0: credit by a shifted gamma density fitted to so many of the person's reactions, measured before the
    session; 0: by the density of `play`."""

    def __post_init__(self) -> None:
        if not self.hours > 0:
            raise ValueError(f"a trial takes more than 0 hours, got {self.hours}")
        if self.calibration_trials and (self.calibration_trials < 10 or self.play.person is None):
            raise ValueError(
                f"a fit needs a person and at least 10 reactions, got {self.calibration_trials} of "
                f"{self.play.person}"
            )


def own_fit(trial: KeepawayTrial, calibration_trials: int) -> KeepawayTrial:
    """Return the trial with credit by the participant's own fitted delay in place of a given one."""
    return msgspec.structs.replace(trial, calibration_trials=calibration_trials)


def run_trial(settings: KeepawayTrial, root_seed: int) -> dict[str, Floats]:
    """Play a trial; a pure function of its arguments.

    Trials of one seed meet the same kick-offs, and people with the same draws, under every condition.

    Returns:
        Columns with one number per episode: seconds it lasted, hours of play at its end, presses that
            counted, w_h
        (trust during the episode; `keepaway_pages.weights_used` gives the weight in use), whether the ball
        went out (1) or was taken (0).
    """
    game = ArlAutoplay(_calibrated(settings, root_seed), root_seed, "keepaway trial")
    limit_s, played_s = settings.hours * S_PER_HOUR, 0.0
    rows: list[tuple[float, ...]] = []
    while played_s < limit_s:
        episode = game.play_episode()
        played_s += episode.duration_s
        hours = played_s / S_PER_HOUR
        rows.append((episode.duration_s, hours, episode.accepted, episode.trust, episode.out))
    table = np.array(rows, np.float64)
    return dict(zip(("seconds", "hours", "presses", "w_h", "out"), table.T, strict=True))


def quick(settings: KeepawayTrial) -> KeepawayTrial:
    """Return a trial of a second: six minutes of play."""
    return msgspec.structs.replace(settings, hours=0.1)


def measured_delay(true: Density, n: int, *, root_seed: int) -> GammaDelay:
    """Return the shifted gamma density fitted to n reactions of a participant whose delay has the density
    `true`.
    """
    rng = stream(root_seed, "calibration")
    fit = fit_family(SHIFTED_GAMMA, sample([draw_delay_s(true, rng=rng) for _ in range(n)]))
    return GammaDelay(*SHIFTED_GAMMA.values(fit.parameters))


def mean_by_time(rows: dict[str, Floats], column: str, hours: float, bins: int) -> Floats:
    """Return a column's mean over the episodes that end in each of `bins` equal parts of `hours`, shape
    (bins,).

    Trials have different numbers of episodes; simulated time is what they share. A part in which no episode
    ends has the value of the episode that spans it.
    """
    if bins < 1:
        raise ValueError(f"need at least one bin, got {bins}")
    ends = rows["hours"]
    edges = np.searchsorted(ends, hours * np.arange(bins + 1) / bins, side="right")
    means = np.empty(bins)
    for k in range(bins):
        first, last = edges[k], edges[k + 1]
        if first == last:
            first, last = min(first, len(ends) - 1), min(first, len(ends) - 1) + 1
        means[k] = rows[column][first:last].mean()
    return means


def _calibrated(settings: KeepawayTrial, root_seed: int) -> ArlKeepawayConfig:
    play = settings.play
    if not settings.calibration_trials:
        return play
    assert play.person is not None, "checked by the settings"
    delay = measured_delay(
        one_density(play.person.trainer.delay), settings.calibration_trials, root_seed=root_seed
    )
    credit = msgspec.structs.replace(play.agent.credit, delay=delay)
    agent = msgspec.structs.replace(play.agent, credit=credit)
    return msgspec.structs.replace(play, agent=agent)
