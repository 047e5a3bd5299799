"""Every game that is registered keeps the contracts, whichever package brings it: nothing here names one."""

from typing import Any

import msgspec
import numpy as np
import pytest

from core.domain import Domain
from core.events import ActionRecord, StepTaken
from core.plugins import GamePlugin, plugins
from core.registry import game_of
from tests.contracts.domain_contract import DomainContract

PLUGINS = tuple(plugins())


each_game = pytest.mark.parametrize("plugin", PLUGINS, ids=[plugin.name for plugin in PLUGINS])


def domain_of(plugin: GamePlugin) -> Domain[Any]:
    protocol = plugin.default()
    return game_of(protocol).domain(protocol)


class TestRegistered(DomainContract):
    """All of the contract of a domain, under the game's default protocol."""

    @pytest.fixture(params=PLUGINS, ids=[plugin.name for plugin in PLUGINS])
    def domain(self, request):
        return domain_of(request.param)


def step_of(record: ActionRecord) -> StepTaken:
    return StepTaken(
        episode=0, step=4, time_ns=0, inputs=0, action=0, environment_action=0, human_action=-1,
        detail=record.plain(), reward=0.0,
    )  # fmt: skip


def test_the_program_brings_three_games() -> None:
    assert {"tetris", "keepaway", "gymnasium"} <= {plugin.name for plugin in PLUGINS}


@each_game
def test_an_action_is_the_games_own_record_and_is_read_back(plugin: GamePlugin) -> None:
    domain = domain_of(plugin)
    state = next(s for s in map(domain.initial, range(20)) if not domain.terminal(s))
    for action in range(len(domain.choices(state).ruled_out)):
        record = domain.action_record(state, action)
        assert type(record) is plugin.action
        step = step_of(record)
        again = msgspec.json.decode(msgspec.json.encode(step), type=StepTaken)
        assert plugin.action.of(again) == record
        # Recordings hold the fields alone, in the order in which the game declares them.
        assert tuple(again.detail) == plugin.action.__struct_fields__


@each_game
def test_an_action_of_another_game_is_refused(plugin: GamePlugin) -> None:
    class Unheard(ActionRecord, frozen=True):
        unheard: int

    with pytest.raises(
        ValueError, match=f"step 4 was .*unheard.*expected {plugin.action.__struct_fields__[0]}"
    ):
        plugin.action.of(step_of(Unheard(1)))


@each_game
def test_an_agent_of_the_default_protocol_chooses_and_learns(plugin: GamePlugin) -> None:
    domain = domain_of(plugin)
    protocol = plugin.default()
    agent = game_of(protocol).agent(protocol, 1)
    policy = agent.begin_episode(exploring=True, watched=False)
    state = next(s for s in map(domain.initial, range(20)) if not domain.terminal(s))
    choices = domain.choices(state)
    decision = agent.choose(choices, policy, step=0)
    assert 0 <= decision.action < len(choices.ruled_out)
    assert np.isfinite(domain.transition(state, decision.action).reward)


@each_game
def test_defaults_pace_and_views_hold_together(plugin: GamePlugin) -> None:
    protocol = plugin.default()
    assert protocol.game == plugin.name
    assert isinstance(protocol.domain, plugin.config)
    assert isinstance(protocol.learner, plugin.learners)
    assert isinstance(protocol.agent.human_model, plugin.human_models)
    assert plugin.expected_game_s(protocol) > 0
    steps = game_of(protocol).steps_on_screen(protocol)
    assert steps
    assert all(step.duration_ns >= 0 for step in steps)
    assert any(step.duration_ns > 0 for step in steps)
