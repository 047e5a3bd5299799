"""A person plays: wishes become the agent's own options, and a game is an episode as in a session."""

import pytest

from core.keepaway.pitch import ONGOING, KeepawayConfig
from core.keepaway.practice import KeeperPractice

pytestmark = pytest.mark.jit


def play_out(practice: KeeperPractice, wish: int | None = None, most: int = 4000) -> list[int]:
    """Play to the end of a game; return who was passed to."""
    targets = []
    for _ in range(most):
        if wish is not None:
            practice.pass_to(wish)
        frame = practice.step()
        if frame.target >= 0:
            targets.append(frame.target)
        if frame.ended != ONGOING:
            return targets
    raise AssertionError("the game does not end")


def test_without_a_wish_the_ball_is_held_and_taken() -> None:
    practice = KeeperPractice(KeepawayConfig(), 3)
    assert play_out(practice) == []


def test_a_wish_is_a_pass_to_that_keeper_and_is_used_up() -> None:
    practice = KeeperPractice(KeepawayConfig(), 3)
    holder = next(
        frame.holder for frame in iter(practice.step, None) if 0 <= frame.holder < practice.config.n_keepers
    )
    target = (holder + 1) % practice.config.n_keepers
    practice.pass_to(target)
    passed = {frame.target for frame in (practice.step() for _ in range(5)) if frame.target >= 0}
    assert passed == {target}


def test_the_same_wishes_give_the_same_games_and_the_next_game_is_another() -> None:
    first, again = KeeperPractice(KeepawayConfig(), 5), KeeperPractice(KeepawayConfig(), 5)
    assert play_out(first, 0) == play_out(again, 0)
    assert first.frame == again.frame
    before = first.frame
    following = first.step()
    assert (following.episode, following.cycle) == (2, 0)
    assert following.players != before.players


def test_a_keeper_that_is_not_there_is_refused() -> None:
    with pytest.raises(ValueError, match="keepers are 0 to 2, got 3"):
        KeeperPractice(KeepawayConfig(), 1).pass_to(3)
