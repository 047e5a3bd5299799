"""What a protocol is said to do."""

from typing import Any

import pytest

from core.session.plan import (
    credit_in_words,
    expected_minutes,
    plan,
    unseen_games,
    weight_in_words,
    weights_of_games,
)
from core.session.protocol import DEFAULTS
from core.session.protocol_reading import protocol_from


def test_games_presses_and_minutes_by_hand() -> None:
    protocol = protocol_from({"session": {"episodes": 10, "unseen_before": 7, "unseen_between": 100}})
    assert unseen_games(protocol) == 7 + 9 * 100
    # 10 games of 60 pieces of 8 ticks of 200 ms, 3 s before and 2 s after each: 10 (3 + 96 + 2) / 60
    assert expected_minutes(protocol) == pytest.approx(16.8333, abs=1e-3)
    assert "at most 5 in a game, 50 in all" in plan(protocol)["Presses"]
    # 20 games of 10 s at half speed, 3 s before and 2 s after each: 20 (3 + 20 + 2) / 60
    slow = protocol_from({"screen": {"speed": 0.5}}, game="keepaway")
    assert expected_minutes(slow) == pytest.approx(25 / 3)


@pytest.mark.parametrize(
    ("agent", "told"),
    [
        ({}, "linear: w_h by bootstrap learning (equation-4): 0 before the first press"),
        ({"bootstrap": {"trust": {"type": "fixed", "w_h": 2.0}}}, "then 2 in every game"),
        ({"scheme": "environment-only"}, "0 in every game"),
        ({"scheme": "human-only"}, "w_r = 0, w_h 1 in every game"),
        ({"scheme": {"type": "constant", "w_h": 0.5}}, "w_r = 1, w_h 0.5 in every game"),
        ({"scheme": "control-sharing"}, "probability of the participant's choice 1"),
    ],
)
def test_the_weight_of_the_participant_is_told_for_each_scheme(agent: dict[str, Any], told: str) -> None:
    assert told in weight_in_words(protocol_from({"agent": agent}))


def test_a_weight_that_falls_is_told_game_by_game() -> None:
    protocol = protocol_from(
        {
            "agent": {"scheme": {"type": "annealed", "decay": 0.5}},
            "session": {"episodes": 9, "unseen_before": 0, "unseen_between": 0},
        }
    )
    assert [each.w_h for each in weights_of_games(protocol)] == [0.5**game for game in range(9)]
    text = weight_in_words(protocol)
    assert "1, 0.5, 0.25, 0.12, 0.062, ..., 0.0039 in games 1 to 9" in text
    assert "from game 8 on below 1% of the first" in text  # 0.5^7 = 0.0078


@pytest.mark.parametrize(
    ("plain", "told"),
    [
        ({}, "previous, as written in the protocol, for every participant"),
        ({"delay_of": "paper"}, "the paper's gamma:2.5,0.3, for every participant"),
        ({"delay_of": "feedback-lag"}, "without one: the session does not start"),
        ({"delay_of": "simple", "delay_if_missing": "paper"}, "simple reaction"),
        ({"delay_of": "pooled", "delay_if_missing": "pooled"}, "the pooled delay of the others"),
    ],
)
def test_whose_delay_gives_credit_is_told(plain: dict[str, Any], told: str) -> None:
    assert told in credit_in_words(protocol_from(plain))


def test_every_topic_is_told_of_every_game() -> None:
    for protocol in DEFAULTS.values():
        assert all(plan(protocol).values())
