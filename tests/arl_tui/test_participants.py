"""What is kept of a participant, and how a session chooses its credit rule by it."""

import csv
from pathlib import Path

import click
import msgspec
import pytest
from click.testing import CliRunner

from arl_tui.app.link import Ready
from arl_tui.cli import main
from arl_tui.commands.credit import credit_lines, settle_credit, with_credit
from arl_tui.commands.demo import demo_protocol
from arl_tui.participants import (
    ParticipantError,
    Quantity,
    TaskDelay,
    choose_credit,
    delays_path,
    home_of,
    keep_delay,
    read_delays,
)
from core.feedback.delays import CurrentStep, Delay, GammaDelay, PreviousStep, parse_delay
from core.recording.reader import read_recording
from core.session.protocol import Protocol
from core.session.protocol_reading import load_protocol
from core.session.session import build_session
from studies.demo import simulate_session
from tests.arl_tui.driving import app_for
from tests.arl_tui.fakes import FakeLink

LAG = GammaDelay(shape=9.0, scale_s=0.07, offset_s=0.1)
SIMPLE = GammaDelay(shape=30.0, scale_s=0.01)
POOLED = GammaDelay(shape=8.0, scale_s=0.09)


def task_delay(task: str = "feedback lag", delay: GammaDelay = LAG, **changes) -> TaskDelay:
    given = {
        "task": task,
        "fitted_utc": "2026-11-22T08:00:00+00:00",
        "files": ("P01-feedback-lag-20261122T075000Z.jsonl",),
        "family": "shifted gamma",
        "delay": delay,
        "mean_s": Quantity(0.73, 0.68, 0.79),
        "median_s": Quantity(0.7, 0.66, 0.75),
        "n_observed": 36,
        "n_censored": 1,
        "left_out": {"practice": 8},
        "policy": {"slow_above_s": 3.0},
        "shape_identified": True,
        "shape_reason": "Shape identified.",
        "verdict": "No other family fits better.",
    }
    return TaskDelay(**{**given, **changes})


def test_what_is_kept_is_read_back_and_other_tasks_stay(tmp_path: Path) -> None:
    assert read_delays(tmp_path, "P01") is None
    keep_delay(tmp_path, "P01", task_delay())
    path = keep_delay(tmp_path, "P01", task_delay("simple", SIMPLE))
    newer = task_delay(delay=GammaDelay(shape=5.0, scale_s=0.1))
    keep_delay(tmp_path, "P01", newer)
    known = read_delays(tmp_path, "P01")
    assert known is not None
    assert known.tasks == {"feedback lag": newer, "simple": task_delay("simple", SIMPLE)}
    assert [each.name for each in path.parent.iterdir()] == ["P01.json"]


def test_participant_means_the_delay_of_judging_not_of_reacting(tmp_path: Path) -> None:
    keep_delay(tmp_path, "P01", task_delay())
    keep_delay(tmp_path, "P01", task_delay("simple", SIMPLE))
    assert choose_credit("participant", tmp_path, "P01").delay == LAG
    assert choose_credit("feedback-lag", tmp_path, "P01").delay == LAG
    simple = choose_credit("simple", tmp_path, "P01")
    assert simple.delay == SIMPLE
    assert any("not an evaluation" in warning for warning in simple.warnings)


def test_the_source_of_a_credit_rule_says_whose_which_and_from_which_trials(tmp_path: Path) -> None:
    keep_delay(tmp_path, "P01", task_delay())
    source = choose_credit("participant", tmp_path, "P01").source
    assert source["credit"] == "participant"
    assert source["credit_rule"] == "gamma:9,0.07,0.1"
    assert source["credit_participant"] == "P01"
    assert source["credit_task"] == "feedback lag"
    assert source["credit_files"] == "P01-feedback-lag-20261122T075000Z.jsonl"


def test_paper_and_rules_need_no_fit(tmp_path: Path) -> None:
    assert choose_credit("paper", tmp_path, "P09").delay == GammaDelay(2.5, 0.3)
    assert choose_credit("previous", tmp_path, "P09").delay == PreviousStep()
    with pytest.raises(ValueError, match="unknown credit rule"):
        choose_credit("nonsense", tmp_path, "P09")


def test_a_missing_fit_is_an_error_that_says_how_to_get_one(tmp_path: Path) -> None:
    with pytest.raises(ParticipantError, match="arl calibrate --participant P09 --tasks feedback-lag"):
        choose_credit("participant", tmp_path, "P09")


def test_pooled_needs_a_pooled_fit(tmp_path: Path) -> None:
    keep_delay(tmp_path, "P01", task_delay())
    with pytest.raises(ParticipantError, match="at least five"):
        choose_credit("pooled", tmp_path, "P01")
    pooled = GammaDelay(shape=8.0, scale_s=0.09)
    keep_delay(tmp_path, "P01", task_delay(n_observed=12, pooled=pooled, pooled_people=6))
    choice = choose_credit("pooled", tmp_path, "P01")
    assert (choice.delay, choice.warnings) == (pooled, ())
    assert choice.source["credit_people"] == "6"


def test_few_answers_an_open_shape_and_a_network_are_warned_of() -> None:
    assert task_delay().warnings == []
    assert "only 12 responses" in task_delay(n_observed=12).warnings[0]
    open_shape = task_delay(shape_identified=False, shape_reason="Shape not identified: why.")
    assert open_shape.warnings == ["Shape not identified: why."]
    assert "SSH" in task_delay(connection={"hindrances": "SSH"}).warnings[0]


@pytest.mark.parametrize(("n_late", "warned"), [(0, False), (3, False), (4, True)])
def test_a_delay_measured_on_a_busy_computer_says_so(n_late: int, warned: bool) -> None:
    found = task_delay(n_observed=36, n_censored=1, n_late=n_late).warnings
    assert [f"in {n_late} trials the stimulus came more than 60 ms late" in words for words in found] == [
        True
    ] * warned


@pytest.mark.parametrize("content", [b"{}", b"not json", b'{"format":"arl-participant-delays","version":1'])
def test_a_damaged_file_is_an_error_that_names_it(tmp_path: Path, content: bytes) -> None:
    path = delays_path(tmp_path, "P01")
    path.parent.mkdir()
    path.write_bytes(content)
    with pytest.raises(ParticipantError, match=r"P01\.json"):
        read_delays(tmp_path, "P01")


def test_somebody_elses_file_is_not_taken(tmp_path: Path) -> None:
    path = keep_delay(tmp_path, "P02", task_delay())
    path.rename(path.with_name("P01.json"))
    with pytest.raises(ParticipantError, match="of P02"):
        read_delays(tmp_path, "P01")


def test_the_participants_of_a_recording_are_looked_for_beside_it_and_above(tmp_path: Path) -> None:
    keep_delay(tmp_path, "P01", task_delay())
    assert home_of(tmp_path / "P01-20261122T080000Z.jsonl") == tmp_path.resolve()
    assert home_of(tmp_path / "imported" / "x.jsonl") == tmp_path.resolve()


def test_a_protocol_takes_the_delay_and_keeps_everything_else(tmp_path: Path) -> None:
    keep_delay(tmp_path, "P01", task_delay())
    protocol = Protocol()
    changed = with_credit(protocol, choose_credit("participant", tmp_path, "P01"))
    assert changed.agent.credit.delay == LAG
    back = msgspec.structs.replace(changed, agent=protocol.agent)
    assert back == protocol
    assert any("gamma:9,0.07,0.1" in sentence for sentence in changed.departures())


def test_replay_learns_again_with_the_participants_own_delay(tmp_path: Path) -> None:
    path = tmp_path / "P01-x.jsonl"
    simulate_session(demo_protocol("tetris"), 4, path, software={})
    recorded = ["replay", str(path), "--games", "2", "--workers", "1", "--credit", "participant"]
    missing = CliRunner().invoke(main, recorded)
    assert missing.exit_code == 1
    assert "has no fit of the task 'feedback lag'" in missing.output
    keep_delay(tmp_path, read_recording(path).header.participant, task_delay())
    done = CliRunner().invoke(main, recorded)
    assert done.exit_code == 0, done.output
    assert "gamma:9,0.07,0.1" in done.output


async def test_the_recordings_header_says_where_the_credit_rule_comes_from(
    tmp_path: Path, protocol: Protocol, link: FakeLink
) -> None:
    keep_delay(tmp_path, "P01", task_delay())
    choice = choose_credit("participant", tmp_path, "P01")
    app = app_for(with_credit(protocol, choice), link, tmp_path, source=choice.source)
    async with app.run_test(size=(80, 24)) as pilot:
        link.say(Ready(warm_up_ns=1))
        await pilot.press("enter")
        await pilot.pause()
    (path,) = tmp_path.glob("P01-*.jsonl")
    header = read_recording(path).header
    assert header.source == choice.source
    assert header.terminal["timing"].startswith("none for this machine and terminal")
    assert header.protocol["agent"]["credit"]["delay"] == {
        "type": "gamma",
        "shape": 9.0,
        "scale_s": 0.07,
        "offset_s": 0.1,
    }


def protocol_file(folder: Path, delay_of: str) -> Path:
    path = folder / "study.toml"
    path.write_text(f'delay_of = "{delay_of}"\n[agent.credit.delay]\ntype = "current"\n')
    return path


@pytest.mark.parametrize(
    ("delay_of", "option", "rule", "by"),
    [
        ("feedback-lag", None, LAG, "protocol"),
        ("simple", None, SIMPLE, "protocol"),
        ("pooled", None, POOLED, "protocol"),
        ("paper", None, GammaDelay(), "protocol"),
        ("rule", None, CurrentStep(), "protocol"),
        ("rule", "participant", LAG, "command line"),
        ("feedback-lag", "simple", SIMPLE, "command line"),
        ("feedback-lag", "previous", PreviousStep(), "command line"),
    ],
)
def test_the_protocol_chooses_whose_delay_gives_credit_and_the_command_line_overrules_it(
    tmp_path: Path, delay_of: str, option: str | None, rule: Delay, by: str
) -> None:
    keep_delay(tmp_path, "P01", task_delay(pooled=POOLED, pooled_people=6))
    keep_delay(tmp_path, "P01", task_delay("simple", SIMPLE))
    protocol = load_protocol(protocol_file(tmp_path, delay_of))
    settled, source = settle_credit(protocol, option, tmp_path, "P01")
    assert settled.agent.credit.delay == rule
    assert settled.delay_of == "rule"
    assert source["credit"] == (option or delay_of)
    assert source["credit_asked_by"] == by
    assert parse_delay(source["credit_rule"]) == rule


def test_without_a_protocol_file_the_rule_is_the_default_protocols_for_every_participant(
    tmp_path: Path,
) -> None:
    def settle(participant: str, option: str | None = None) -> tuple[Delay, str, str]:
        settled, source = settle_credit(load_protocol(None), option, tmp_path, participant)
        return settled.agent.credit.delay, source["credit"], source["credit_asked_by"]

    as_written = Protocol().agent.credit.delay
    keep_delay(tmp_path, "P01", task_delay())
    assert settle("P01") == settle("P09") == (as_written, "rule", "protocol")
    assert settle("P01", "participant") == (LAG, "participant", "command line")
    assert settle("P01", "paper") == (GammaDelay(), "paper", "command line")
    delays_path(tmp_path, "P01").write_text("rubbish")
    with pytest.raises(click.ClickException, match="not a participant's delays"):
        settle("P01", "participant")


def test_a_file_with_the_defaults_gives_the_same_rule_as_no_file(tmp_path: Path) -> None:
    keep_delay(tmp_path, "P01", task_delay())
    path = tmp_path / "study.toml"
    path.write_text(CliRunner().invoke(main, ["protocol"]).output)
    written = settle_credit(load_protocol(path), None, tmp_path, "P01")
    assert written == settle_credit(load_protocol(None), None, tmp_path, "P01")


def test_a_participant_without_a_measured_delay_has_what_the_protocol_says(tmp_path: Path) -> None:
    path = tmp_path / "study.toml"
    path.write_text('delay_of = "feedback-lag"\ndelay_if_missing = "paper"\n')
    settled, source = settle_credit(load_protocol(path), None, tmp_path, "P09")
    assert settled.agent.credit.delay == GammaDelay()
    assert source["credit"] == "paper"
    assert source["credit_asked"] == "feedback-lag"
    assert source["credit_missing"] == "P09 has no measured delay: paper"
    path.write_text('delay_of = "feedback-lag"\ndelay_if_missing = "pooled"\n')
    with pytest.raises(click.ClickException, match=r"no pooled delay of judging tetris .*at least 5"):
        settle_credit(load_protocol(path), None, tmp_path, "P09")


def test_the_experimenter_is_told_whose_delay_gives_credit_and_from_which_trials(tmp_path: Path) -> None:
    keep_delay(tmp_path, "P01", task_delay())
    protocol = load_protocol(protocol_file(tmp_path, "feedback-lag"))
    _, source = settle_credit(protocol, None, tmp_path, "P01")
    told = " ".join(credit_lines(source, tmp_path, "P01", "tetris"))
    assert "gamma:9,0.07,0.1 (feedback-lag, asked for by the protocol)" in told
    assert "from P01-feedback-lag-20261122T075000Z.jsonl" in told
    _, source = settle_credit(load_protocol(None), None, tmp_path, "P01")
    assert "P01 has a measured delay of judging, which is not used" in " ".join(
        credit_lines(source, tmp_path, "P01", "tetris")
    )


def test_a_protocol_that_needs_a_measured_delay_stops_where_there_is_none(tmp_path: Path) -> None:
    protocol = load_protocol(protocol_file(tmp_path, "feedback-lag"))
    with pytest.raises(click.ClickException, match="P01 has no fit of the task 'feedback lag'"):
        settle_credit(protocol, None, tmp_path, "P01")
    with pytest.raises(ValueError, match="delay_of is 'feedback-lag'"):
        build_session(protocol, 1)


def test_a_what_if_stores_where_a_participants_delay_comes_from(tmp_path: Path) -> None:
    path, table = tmp_path / "P01-x.jsonl", tmp_path / "t.csv"
    simulate_session(demo_protocol("tetris"), 4, path, software={})
    keep_delay(tmp_path, read_recording(path).header.participant, task_delay())
    asked = ["replay", str(path), "--games", "2", "--workers", "1", "--csv", str(table)]
    done = CliRunner().invoke(main, [*asked, "--credit", "feedback-lag", "--credit", "previous"])
    assert done.exit_code == 0, done.output
    with table.open(newline="") as file:
        measured, previous = csv.DictReader(file)
    assert "task feedback lag" in measured["credit_source"]
    assert "files P01-feedback-lag-20261122T075000Z.jsonl" in measured["credit_source"]
    assert measured["credit_source"] in " ".join(done.output.split())
    assert previous["credit_source"] == "credit previous; rule previous"
    by_protocol = [
        *asked,
        "--scheme",
        "human-only",
        "--protocol",
        str(protocol_file(tmp_path, "feedback-lag")),
    ]
    again = CliRunner().invoke(main, by_protocol)
    assert again.exit_code == 0, again.output
    assert "gamma:9,0.07,0.1" in again.output
