"""`arl replay` of sessions of several people and with grades: what-ifs from the command line."""

from pathlib import Path

import msgspec
import pytest
from click.testing import CliRunner, Result

from arl_tui.cli import main
from core.feedback.delays import GammaDelay, PerValueDelay
from core.feedback.keys import KeyConfig
from core.feedback.people import PersonConfig
from tests.core.sessions import simulated, small_protocol

PEOPLE = (
    PersonConfig(name="A01", good="j", bad="f", retract="u"),
    PersonConfig(name="B02", good="w", bad="q", retract="e", delay=GammaDelay(2.5, 0.4)),
)


def run(*arguments: str | Path) -> Result:
    return CliRunner().invoke(main, list(map(str, arguments)))


@pytest.fixture(scope="module")
def crowd(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return simulated(tmp_path_factory.mktemp("crowd"), small_protocol(people=PEOPLE)).path


@pytest.fixture(scope="module")
def graded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    keys = KeyConfig(graded=("d", "f", "g", "h", "j"), max_presses_per_episode=20)
    return simulated(tmp_path_factory.mktemp("graded"), small_protocol(keys=keys)).path


def test_a_density_per_value_stands_beside_one_for_all(graded: Path) -> None:
    result = run(
        "replay", graded, "--credit", "per-value", "--credit", "gamma", "--games", "3", "--workers", "1"
    )
    assert result.exit_code == 0, result.output
    rows = [
        line.split()[0] for line in result.output.splitlines() if line.startswith(("per-value ", "gamma"))
    ]
    assert rows == ["per-value", "gamma:2.5,0.3"] * 2
    assert "per-value: -2=gamma:2.5,0.345;" in result.output


def test_a_table_of_ones_own_can_stand_in_the_command(graded: Path) -> None:
    rule = "per-value:2=gamma:2.2,0.3;other=uniform:0.2,1.5"
    result = run("replay", graded, "--credit", rule, "--games", "2", "--workers", "1")
    assert result.exit_code == 0, result.output
    assert "per-value: 2=gamma:2.2,0.3;other=uniform:0.2,1.5." in result.output


def test_a_rule_that_is_asked_for_is_everybodys(crowd: Path) -> None:
    alike = run("replay", crowd, "--credit", "previous", "--games", "2", "--workers", "1")
    own = run("replay", crowd, "--scheme", "linear", "--games", "2", "--workers", "1")
    assert alike.exit_code == own.exit_code == 0, alike.output + own.output
    assert "several people: each has a human model of their own" in own.output
    taught = [
        next(line for line in output.splitlines()[::-1] if line.startswith("previous"))
        for output in (alike.output, own.output)
    ]
    assert taught[0] != taught[1]  # B02 is credited by a density of their own in one of them


def test_a_measured_delay_is_no_rule_for_several(crowd: Path) -> None:
    result = run("replay", crowd, "--credit", "participant", "--games", "2")
    assert result.exit_code == 1
    assert "A01, B02 have delays of their own" in " ".join(result.output.split())


def test_the_list_of_recordings_counts_each_persons_presses(crowd: Path) -> None:
    result = run("recordings", "--recordings", crowd.parent)
    assert result.exit_code == 0, result.output
    assert "A01 " in result.output
    assert "B02 " in result.output


def test_a_graded_rule_of_the_protocol_is_the_one_that_per_value_names(tmp_path: Path) -> None:
    own = PerValueDelay((), GammaDelay(2.0, 0.2))
    protocol = small_protocol()
    credit = msgspec.structs.replace(protocol.agent.credit, delay=own)
    agent = msgspec.structs.replace(protocol.agent, credit=credit)
    path = simulated(tmp_path, msgspec.structs.replace(protocol, agent=agent)).path
    result = run("replay", path, "--credit", "per-value", "--games", "2", "--workers", "1")
    assert result.exit_code == 0, result.output
    assert "per-value: other=gamma:2,0.2." in result.output
