"""The simulated participant beside the real one."""

from msgspec.structs import replace

from arl_tui.app.demo_participant import DemoParticipant
from core.events import EpisodeStarted, StepTaken
from core.feedback.trainers import TrainerConfig
from core.numerics.clock import ManualClock
from core.session.protocol import Protocol, SessionConfig
from core.session.session import build_session

SECOND = 1_000_000_000


class NoFeedback:
    def during(self, step: int) -> list[object]:
        return []


def suggestions(trainer: TrainerConfig, root_seed: int = 3) -> list[tuple[int, str, int]]:
    """Return (step, key, delay behind the end of the step in ns) of all presses in a short session."""
    protocol = Protocol(
        session=SessionConfig(episodes=2, unseen_between=2, watched_steps=15), trainer=trainer
    )
    session = build_session(protocol, root_seed)
    demo_participant = DemoParticipant(session, protocol, root_seed)
    found = []
    for output in session.run(NoFeedback(), ManualClock()):  # type: ignore[arg-type]
        if isinstance(output, EpisodeStarted):
            demo_participant.begin(output)
        elif isinstance(output, StepTaken):
            shown_ns = output.step * SECOND
            for press in demo_participant.watch(output, shown_ns=shown_ns, hidden_ns=shown_ns + SECOND):
                found.append((output.step, press.key, press.time_ns - shown_ns - SECOND))
    return found


TALKATIVE = TrainerConfig(press_probability=1.0, mistake_rate=0.0, max_presses=4)


def test_presses_come_after_the_step_and_within_the_budget_of_each_episode() -> None:
    found = suggestions(TALKATIVE)
    assert [step for step, _, _ in found] == [0, 1, 2, 3, 15, 16, 17, 18]
    assert all(delay_ns > 0 for _, _, delay_ns in found)


def test_an_adversary_presses_the_other_key_each_time() -> None:
    honest = [key for _, key, _ in suggestions(TALKATIVE)]
    adverse = [key for _, key, _ in suggestions(replace(TALKATIVE, mistake_rate=1.0))]
    assert set(honest) <= {"j", "f"}
    assert adverse == [{"j": "f", "f": "j"}[key] for key in honest]


def test_equal_seeds_give_equal_presses_and_other_seeds_others() -> None:
    assert suggestions(TALKATIVE, 3) == suggestions(TALKATIVE, 3)
    assert suggestions(TALKATIVE, 3) != suggestions(TALKATIVE, 4)
