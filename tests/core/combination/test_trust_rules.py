"""Every rule of trust keeps the contract, and a new one takes a file and a line: played, recorded, replayed
exactly."""

import tomllib
from pathlib import Path
from typing import get_args

import msgspec
import numpy as np
import pytest

from core.combination.agreement import Agreement
from core.combination.bootstrap_learning import BootstrapLearning
from core.combination.config import AgentConfig, BootstrapConfig, Equation4, Signed, TrustRule
from core.combination.ranking import EpisodeReport
from core.combination.trust.contract import Needs, Trust, weight_bytes
from core.configuration.open_table import decode_open_table
from core.events import EpisodeEnded
from core.session.protocol import Protocol
from core.session.protocol_reading import protocol_from
from core.session.replay import replay_exactly
from core.session.session import build_session
from tests.core.combination.recent_rule import Recent
from tests.core.sessions import simulated, small_protocol
from tests.documented import blocks_of

RULES = get_args(TrustRule)
DOCS = Path(__file__).resolve().parents[3] / "docs" / "extending.md"


def report(episode: int, agreement: Agreement | None = None) -> EpisodeReport:
    return EpisodeReport(episode, np.ones(2), 5.0 + episode % 7, False, agreement, consistency=9.0)


# --- the contract -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", [*RULES, Recent])
def test_a_rule_says_what_it_needs_and_begins_without_evidence(kind):
    rule = kind()
    assert isinstance(rule.needs, Needs)
    one, other = rule.begin(root_seed=1), rule.begin(root_seed=1)
    assert isinstance(one, Trust)
    assert one is not other, "each participant has a state of their own"
    assert one.w_h == getattr(rule, "w_h", 0.0)
    assert one.state_bytes() == other.state_bytes()
    assert one.state_bytes().startswith(weight_bytes(one.w_h)), "as in every fingerprint recorded so far"


@pytest.mark.parametrize("kind", [*RULES, Recent])
def test_an_episode_without_a_human_policy_leaves_the_weight(kind):
    learning = BootstrapLearning(BootstrapConfig(trust=kind()), None, root_seed=1)
    before = learning.w_h
    for episode in range(30):
        learning.record(report(episode), None)
    assert learning.w_h == before


@pytest.mark.parametrize("kind", [*RULES, Recent])
def test_the_same_episodes_give_the_same_state(kind):
    def state(root_seed: int) -> tuple[float, bytes]:
        learning = BootstrapLearning(BootstrapConfig(trust=kind()), None, root_seed=root_seed)
        for episode in range(150):
            learning.record(report(episode, Agreement(10, 4 + episode % 4, 1)), np.ones(2))
        return learning.w_h, learning.state_bytes()

    assert state(3) == state(3)


@pytest.mark.parametrize("kind", RULES)
def test_every_tag_is_decoded_by_the_union(kind):
    tag = kind.__struct_config__.tag
    assert msgspec.convert({"type": tag}, TrustRule) == kind()
    assert sum(other.__struct_config__.tag == tag for other in RULES) == 1


@pytest.mark.parametrize(
    ("rule", "window", "consistency"),
    [
        (Equation4(), False, False),
        (Equation4(measured="window"), True, False),
        (Equation4(match="chance-corrected"), True, False),
        (Equation4(match="chance-corrected", chance=0.1), False, False),
        (Signed(), False, False),
        (Signed(consistent_above=1.0), False, True),
    ],
    ids=str,
)
def test_what_a_rule_needs_depends_on_its_settings(rule, window, consistency):
    assert rule.needs == Needs(window=window, consistency=consistency)


def test_a_rule_that_needs_a_window_is_refused_where_none_is_kept():
    with pytest.raises(ValueError, match="no window of decisions is kept"):
        BootstrapLearning(BootstrapConfig(trust=Equation4(measured="window")), None, root_seed=1)


# --- a rule of one's own ------------------------------------------------------------------------------------


class BootstrapWithRecent(BootstrapConfig, frozen=True, kw_only=True):
    """As if `Recent` stood in the union `TrustRule`."""

    trust: TrustRule | Recent = Recent()


class AgentWithRecent(AgentConfig, frozen=True, kw_only=True):
    bootstrap: BootstrapWithRecent = BootstrapWithRecent()


class ProtocolWithRecent(Protocol, frozen=True, kw_only=True):
    agent: AgentWithRecent = AgentWithRecent()


def protocol_with(rule: Recent) -> ProtocolWithRecent:
    plain = msgspec.to_builtins(small_protocol())
    plain["agent"]["bootstrap"]["trust"] = msgspec.to_builtins(rule)
    return msgspec.convert(plain, ProtocolWithRecent, dec_hook=decode_open_table)


def test_the_documentation_adds_this_rule_in_less_than_forty_lines():
    example = (Path(__file__).parent / "recent_rule.py").read_text(encoding="utf-8")
    assert f"```python\n{example}```" in DOCS.read_text(encoding="utf-8")
    assert len(example.splitlines()) < 40


def test_the_rule_of_the_documentation_by_hand():
    learning = BootstrapLearning(BootstrapWithRecent(trust=Recent(episodes=2)), None, root_seed=1)
    for episode, agreed in enumerate((9, 2, 6)):
        learning.record(report(episode, Agreement(10, agreed, 0)), np.ones(2))
    assert learning.w_h == pytest.approx((0.2 + 0.6) / 2)


def test_a_session_under_a_new_rule_is_recorded_and_replayed_bit_for_bit(tmp_path: Path):
    recording = simulated(tmp_path, protocol_with(Recent(episodes=3)))
    (documented, *_) = (block for block in blocks_of(DOCS) if block.language == "toml")
    trust = recording.header.protocol["agent"]["bootstrap"]["trust"]
    assert {"agent": {"bootstrap": {"trust": trust}}} == tomllib.loads(documented.text)
    protocol = msgspec.convert(recording.header.protocol, ProtocolWithRecent, dec_hook=decode_open_table)
    session = build_session(protocol, recording.header.root_seed)
    assert replay_exactly(recording, session).difference is None
    weights = [output.trust for output in recording.outputs if isinstance(output, EpisodeEnded)]
    assert len(set(weights)) > 1, "the rule has revised something"
    # A rule that revises otherwise does not replay this session.
    other = build_session(protocol_with(Recent(episodes=1)), recording.header.root_seed)
    assert replay_exactly(recording, other).difference is not None


def test_a_rule_outside_the_union_is_refused_with_the_known_ones():
    plain = msgspec.to_builtins(protocol_with(Recent()))
    with pytest.raises(ValueError, match="recent"):
        protocol_from(plain)
