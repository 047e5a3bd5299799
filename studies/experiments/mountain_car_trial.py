"""One trial of Mountain Car: a session of Sarsa that a simulated teacher watches, episode by episode."""

import msgspec
import numpy as np

from core.events import CreditGiven, EpisodeEnded, EpisodeStarted
from core.feedback.keys import PressGate
from core.feedback.source import SimulatedParticipant
from core.feedback.trainers import SimulatedTrainer
from core.numerics.arrays import Floats
from core.numerics.clock import ManualClock
from core.session.protocol import Protocol
from core.session.session import Session
from studies.experiments.mountain_car_task import CarState, MountainCarGame


def run_trial(protocol: Protocol, root_seed: int) -> dict[str, Floats]:
    """Play a trial; a pure function of its arguments.

    Trials of one seed meet the same starts under every condition.

    Returns:
        Columns with one number per episode: steps, presses that were credited in it (or in the pause before),
        trust (what the rule of trust said of the teacher), w_h (the weight of the participant's values that
        the scheme used), reached (1 where the car came to the flag).
    """
    game = MountainCarGame()
    agent, domain, clock = game.agent(protocol, root_seed), game.domain(protocol), ManualClock()
    session = Session(domain, agent, game.player(protocol, agent), protocol.session, root_seed=root_seed)
    participant = SimulatedParticipant[CarState](
        domain,
        game.oracle(protocol),
        SimulatedTrainer(protocol.trainer, root_seed=root_seed),
        PressGate(protocol.keys),
        clock,
        game.viewing(protocol),
    )
    rows: list[tuple[float, ...]] = []
    presses, weights = 0, (0.0, 0.0)
    for output in session.run(participant, clock):
        participant.watch(output)
        match output:
            case EpisodeStarted(trust=trust, weight=weight):
                weights = (0.0 if trust is None else trust, weight)
            case CreditGiven():
                presses += 1
            case EpisodeEnded(steps=steps, ended=ended):
                rows.append((steps, presses, *weights, ended == "termination"))
                presses = 0
            case _:
                pass
    table = np.array(rows, np.float64)
    return dict(zip(("steps", "presses", "trust", "w_h", "reached"), table.T, strict=True))


def quick(protocol: Protocol) -> Protocol:
    """Return a trial of a second: three short episodes."""
    session = msgspec.structs.replace(protocol.session, episodes=3, watched_steps=200)
    return msgspec.structs.replace(protocol, session=session)
