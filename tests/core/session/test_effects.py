"""In which sessions settings have an effect: `core.session.effects` against sessions that are played."""

from pathlib import Path
from typing import Any

import msgspec
import pytest

from core.configuration.catalogue import settings_of, tables_of
from core.configuration.reading import ConfigurationError
from core.session.contradictions import warnings_of
from core.session.effects import MODES, changed, idle, uses, uses_of
from core.session.protocol import DEFAULTS, Protocol
from core.session.protocol_file import ProtocolError
from core.session.protocol_reading import load_protocol, protocol_from
from tests.core.sessions import simulated

SMALL = {
    "tetris": {
        "session": {"episodes": 2, "unseen_between": 5, "watched_steps": 12, "unseen_steps": 60},
        "trainer": {"press_probability": 0.6},
    },
    "keepaway": {
        "session": {"episodes": 2, "watched_steps": 40, "unseen_steps": 40},
        "trainer": {"press_probability": 1.0},
    },
}


def protocol_of(game: str, *plains: dict[str, Any]) -> Protocol:
    merged: dict[str, Any] = {"domain": {"type": game}}
    for plain in (SMALL[game], *plains):
        merged = merge(merged, plain)
    return protocol_from(merged, game=game)


def merge(first: dict[str, Any], second: dict[str, Any]) -> dict[str, Any]:
    both = {
        key: merge(first[key], second[key])
        for key in first.keys() & second.keys()
        if isinstance(first[key], dict)
    }
    return {**first, **second, **both}


def nested(path: str, value: object) -> dict[str, Any]:
    inner: Any = value
    for key in reversed(path.split(".")):
        inner = {key: inner}
    found: dict[str, Any] = inner
    return found


NATURAL_OFF = {"learner": {"type": "policy-gradient"}}
EXACT = {"domain": {"exact_state": True}}
COACH = {
    "learner": {"type": "policy-gradient"},
    "agent": {"scheme": {"type": "coach", "environment_too": False}},
    "session": {"watched": "proposed"},
}

ASKING = {"agent": {"asking": {"share": 0.6, "minimum_decisions": 2}}}
ASKING_ONCE = {"agent": {"asking": {"share": 0.6, "minimum_decisions": 2, "per_episode": 1}}}

# In simulated sessions none of these changes anything: not a step, not a weight, not a fingerprint.
WITHOUT_EFFECT = [
    ("tetris", {}, "screen.speed", 0.5),
    ("tetris", {}, "screen.palette", "high-contrast"),
    ("tetris", {}, "agent.asking.share", 0.5),
    ("tetris", {}, "agent.bootstrap.window_decisions", 7),
    ("tetris", {}, "agent.bootstrap.trust.chance", 0.3),
    ("tetris", {"session": {"watched": "proposed"}}, "agent.bootstrap.symmetric", False),
    ("tetris", {}, "keys.wrong_press_rate", 0.5),
    ("tetris", {}, "delay_if_missing", "paper"),
    ("tetris", {}, "trainer.burst_presses", 5),
    ("tetris", {}, "trainer.burst_interval_s", 0.5),
    ("tetris", {"session": {"unseen_between": 0}}, "session.unseen_steps", 7),
    ("tetris", {"session": {"episodes": 1}}, "session.unseen_between", 7),
    ("tetris", NATURAL_OFF, "learner.fisher_rate", 0.5),
    ("tetris", NATURAL_OFF, "learner.fisher_ridge", 0.5),
    ("tetris", COACH, "learner.step_size", 0.5),
    ("tetris", COACH, "learner.update", "episode"),
    ("keepaway", {}, "screen.tick_ms", 150),
    ("keepaway", {}, "session.watched", "proposed"),
    ("keepaway", {}, "agent.bootstrap.symmetric", False),
    ("keepaway", {}, "learner.replacing_traces", False),
    ("keepaway", {}, "learner.least_trace", 0.5),
    ("keepaway", EXACT, "domain.view_angle_deg", 90.0),
    ("keepaway", EXACT, "domain.quantise", False),
]
# And each of these changes something, where it is said to have an effect.
WITH_EFFECT = [
    ("tetris", {}, "screen.tick_ms", 150),
    ("tetris", {}, "screen.pause_between_episodes_s", 0.1),
    ("tetris", {}, "session.watched", "proposed"),
    ("tetris", {}, "session.unseen_steps", 7),
    ("tetris", {}, "trainer.mistake_rate", 1.0),
    ("tetris", ASKING, "agent.asking.per_episode", 3),
    ("tetris", ASKING_ONCE, "agent.asking.settle_s", 0.5),
    ("tetris", {}, "agent.credit.delay", {"type": "current"}),
    ("tetris", {"trainer": {"burst_rate": 1.0}}, "trainer.burst_interval_s", 0.5),
    ("keepaway", {}, "screen.speed", 0.5),
    ("keepaway", {}, "domain.quantise", False),
]


@pytest.mark.jit
@pytest.mark.parametrize(("game", "base", "setting", "value"), WITHOUT_EFFECT)
def test_what_is_said_to_have_no_effect_has_none(
    tmp_path: Path, game: str, base: dict[str, Any], setting: str, value: object
) -> None:
    usual = protocol_of(game, base)
    other = protocol_of(game, base, nested(setting, value))
    assert usual != other
    told = [".".join(map(str, each.path)) for each in idle(other, DEFAULTS[game], ["simulated"])]
    assert any(setting.startswith(path) for path in told)
    before, after = simulated(tmp_path / "a", usual), simulated(tmp_path / "b", other)
    assert before.events == after.events


@pytest.mark.jit
@pytest.mark.parametrize(("game", "base", "setting", "value"), WITH_EFFECT)
def test_what_is_said_to_have_an_effect_has_one(
    tmp_path: Path, game: str, base: dict[str, Any], setting: str, value: object
) -> None:
    usual = protocol_of(game, base)
    other = protocol_of(game, base, nested(setting, value))
    assert setting not in [
        ".".join(map(str, each.path)) for each in idle(other, DEFAULTS[game], ["simulated"])
    ]
    assert simulated(tmp_path / "a", usual).events != simulated(tmp_path / "b", other).events


def test_every_entry_speaks_of_settings_that_there_are() -> None:
    known = set(settings_of(Protocol))
    for path, kind in tables_of(Protocol):
        for struct in (kind.structs or {}).values():
            known |= {".".join((*path, key)) for key in settings_of(struct)}
    for use in uses():
        assert set(use.settings) <= known


def test_the_default_protocols_have_nothing_idle_and_differ_from_nothing() -> None:
    for default in DEFAULTS.values():
        assert list(changed(default, default)) == []
        for mode in MODES:
            assert idle(default, default, [mode]) == []
        assert list(warnings_of(default)) == []


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("[screen]\nspeed = 2.0\n", "[screen] speed = 2.0"),
        ('[domain]\ntype = "keepaway"\n[screen]\ntick_ms = 150\n', "[screen] tick_ms = 150"),
        ("[agent.asking]\nshare = 0.3\n", "[agent.asking] share = 0.3"),
        ("[agent.bootstrap]\nwindow_decisions = 5\n", "[agent.bootstrap] window_decisions = 5"),
        ('[learner]\ntype = "policy-gradient"\nfisher_rate = 0.5\n', "[learner] fisher_rate = 0.5"),
        ('domain = "keepaway"\n[learner]\nleast_trace = 0.5\n', "[learner] least_trace = 0.5"),
        ('delay_if_missing = "paper"\n', 'delay_if_missing = "paper"'),
    ],
)
def test_a_setting_without_effect_is_refused_with_its_line(tmp_path: Path, text: str, place: str) -> None:
    path = tmp_path / "study.toml"
    path.write_text(text)
    line = text.splitlines().index(place.rpartition("] ")[2]) + 1
    with pytest.raises(ProtocolError) as caught:
        load_protocol(path)
    assert f"study.toml:{line}: {place}: has no effect" in str(caught.value)


def test_a_setting_at_its_default_is_never_refused() -> None:
    for game, table in (("tetris", {"screen": {"speed": 1.0}}), ("keepaway", {"screen": {"tick_ms": 200}})):
        assert protocol_from(table, game=game, to_run=True) == DEFAULTS[game]


def test_a_setting_at_the_default_of_an_earlier_version_is_never_refused() -> None:
    assert protocol_from({"screen": {"tick_ms": 80}}, game="keepaway", to_run=True).screen.tick_ms == 80


@pytest.mark.parametrize(
    ("plain", "told"),
    [
        ({"trainer": {"mistake_rate": 0.5}}, "[trainer] mistake_rate"),
        ({"others": [{}]}, "others"),
        (
            {"agent": {"scheme": "annealed", "human_model": {"l2": 2.0}}, "session": {"watched": "proposed"}},
            None,
        ),
        ({"agent": {"scheme": "environment-only", "human_model": {"l2": 2.0}}}, "[agent.human_model] l2"),
        ({"agent": {"scheme": "human-only"}, "learner": {"population": 50}}, "[learner] population"),
        ({"delay_of": "paper", "agent": {"credit": {"delay": "current"}}}, "[agent.credit.delay] type"),
    ],
)
def test_what_has_no_effect_in_a_live_session_is_named(plain: dict[str, Any], told: str | None) -> None:
    protocol = protocol_from(plain, to_run=True)
    named = [str(each) for each in idle(protocol, DEFAULTS["tetris"], ["live"])]
    assert [line.split(" has no effect")[0] for line in named] == ([told] if told else [])


def test_trust_is_named_where_nothing_goes_by_it() -> None:
    plain = {"agent": {"scheme": "annealed", "bootstrap": {"trust": {"type": "fixed", "w_h": 2.0}}}}
    drawn = protocol_from(plain, to_run=True)
    assert idle(drawn, DEFAULTS["tetris"], ["live"]) == []
    proposed = protocol_from(plain | {"session": {"watched": "proposed"}}, to_run=True)
    assert [each.path for each in idle(proposed, DEFAULTS["tetris"], ["live"])] == [
        ("agent", "bootstrap", "trust", "type"),
        ("agent", "bootstrap", "trust", "w_h"),
    ]


def test_a_learner_that_never_plays_again_is_named() -> None:
    protocol = protocol_from({"session": {"unseen_between": 0}}, to_run=True)
    assert "teaches nothing after it" in " ".join(warnings_of(protocol))


def test_entries_are_found_for_a_setting_and_for_its_table() -> None:
    assert [use.settings for use in uses_of("trainer.burst_presses")] == [
        ("trainer",),
        ("trainer.burst_presses", "trainer.burst_interval_s"),
    ]
    assert list(uses_of("domain.rows")) == []


def test_a_refusal_names_the_value_and_how_to_go_on() -> None:
    with pytest.raises(
        ConfigurationError, match=r"speed = 2\.0: has no effect .* in Keepaway only: leave it out"
    ):
        protocol_from({"screen": {"speed": 2.0}}, to_run=True)
    assert msgspec.structs.replace(DEFAULTS["tetris"].screen, speed=2.0).speed == 2.0
