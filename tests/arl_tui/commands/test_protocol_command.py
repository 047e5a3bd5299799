"""`arl protocol`: the printed file, the page, and what a file is said to do."""

import re
from pathlib import Path

import msgspec
import pytest
from click.testing import CliRunner, Result

from arl_tui.app.outcome import SessionOutcome
from arl_tui.app.tally import Tally
from arl_tui.cli import main
from arl_tui.commands import play
from arl_tui.commands.check_protocol import tell_start
from arl_tui.commands.demo import demo_protocol
from arl_tui.commands.protocol import protocol_lines
from arl_tui.commands.protocol_page import page
from core.combination.config import SCHEMES
from core.configuration.catalogue import settings_of, tables_of
from core.feedback.config import TrainerConfig
from core.feedback.delays import GammaDelay
from core.session.protocol import DEFAULTS, Protocol
from core.session.protocol_reading import load_protocol, protocol_from
from studies.demo import simulate_session

DOCS = Path(__file__).resolve().parents[3] / "docs"


def run(*arguments: object) -> Result:
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def keys_of(game: str) -> set[tuple[str, str]]:
    """Every key of every table of a game's default protocol, whatever its value."""
    found = {("", setting.key) for setting in settings_of(Protocol).values() if setting.kind.base != "table"}
    for path, kind in tables_of(Protocol):
        value: object = DEFAULTS[game]
        for key in path:
            value = getattr(value, key, None)
        if isinstance(value, msgspec.Struct) and kind.base == "table":
            settings = settings_of(type(value)).values()
            found |= {(".".join(path), s.key) for s in settings if s.kind.base != "table"}
    return found


@pytest.mark.parametrize("game", ["tetris", "keepaway"])
def test_every_key_is_printed_with_its_meaning_and_reads_back(tmp_path: Path, game: str) -> None:
    printed = run("protocol", game).output
    path = tmp_path / "p.toml"
    path.write_text(printed)
    assert load_protocol(path, game=game) == DEFAULTS[game]
    table, found = "", set()
    lines = printed.splitlines()
    for number, line in enumerate(lines):
        if header := re.match(r"\[([\w.]+)\]$", line):
            table = header[1]
        elif (key := re.match(r"(?:# )?([a-z_0-9]+) = ", line)) and key[1] != "type":
            found.add((table, key[1]))
            assert lines[number - 1].startswith("# "), line
    assert found == keys_of(game)
    assert all(len(line) <= 110 for line in lines)


@pytest.mark.parametrize("scheme", sorted(SCHEMES))
def test_any_protocol_reads_back_as_it_was_printed(tmp_path: Path, scheme: str) -> None:
    game = "keepaway" if scheme == "q-augmentation" else "tetris"
    plain: dict[str, object] = {
        "name": 'quote " back \\ \t tab \x7f Käthe',
        "agent": {"scheme": scheme},
        "keys": {"repeat_delay_ms": [100, 300]},
    }
    if scheme in ("coach", "reward-shaping"):
        plain["learner"] = {"type": "policy-gradient", "natural": True, "fisher_rate": 0.5}
    plain["session"] = {"watched": "proposed"} if game == "tetris" else {}
    protocol = msgspec.structs.replace(
        protocol_from(plain, game=game, to_run=True),
        others=(TrainerConfig(mean_presses=2.0), TrainerConfig(stops_after_episodes=3)),
    )
    path = tmp_path / "p.toml"
    path.write_text("\n".join(protocol_lines(protocol)))
    assert load_protocol(path, game=game) == protocol


def test_a_setting_without_effect_is_printed_as_a_comment() -> None:
    tetris, keepaway = run("protocol").output, run("protocol", "keepaway").output
    assert "\n# speed = 1.0\n" in tetris
    assert "\nspeed = 0.2\n" in keepaway
    assert "\ntick_ms = 200\n" in tetris
    assert "\n# tick_ms = 200\n" in keepaway
    assert "# Has an effect in Keepaway only." in tetris


def test_the_page_of_settings_is_current() -> None:
    assert (DOCS / "protocol.md").read_text(encoding="utf-8") == page(), (
        "write it again: arl protocol --markdown > docs/protocol.md"
    )
    assert run("protocol", "--markdown").output == page()


def test_the_page_names_every_key_and_type() -> None:
    text = page()
    for path, kind in tables_of(Protocol):
        assert ".".join(path) in text
        for tag, struct in (kind.structs or {}).items():
            assert f'type = "{tag}"' in text or not tag
            for key, setting in settings_of(struct).items():
                assert f"| `{key}` |" in text or setting.kind.base == "table"


@pytest.mark.jit
def test_a_file_is_said_what_it_will_do(tmp_path: Path) -> None:
    path = tmp_path / "study.toml"
    path.write_text(
        'name = "pilot"\ndelay_of = "feedback-lag"\n[agent.scheme]\ntype = "annealed"\ndecay = 0.5\n'
        "[session]\nepisodes = 4\nunseen_between = 0\n[trainer]\nmistake_rate = 0.5\n"
    )
    result = run("protocol", "--check", path)
    assert result.exit_code == 0, result.output
    told = " ".join(result.output.split())
    for part in (
        "4 watched, each of at most 60 pieces",
        "at most 5 in a game, 20 in all",
        "annealed: w_r = 1, w_h 1, 0.5, 0.25, 0.12 in games 1 to 4",
        (
            "own measured delay of judging this game (task feedback lag); for a participant without one: the "
            "session does"
        ),
        "of a press reaches the step it was meant for",
        "the kernels of tetris",
        "[trainer] mistake_rate has no effect here",
        "teaches nothing after it",
    ):
        assert part in told


def test_a_wrong_file_is_not_checked_further(tmp_path: Path) -> None:
    path = tmp_path / "study.toml"
    path.write_text("[session]\nepisode = 2\n")
    result = run("protocol", "--check", path)
    assert result.exit_code == 1
    assert "study.toml:2: [session] episode = 2" in result.output
    assert "Traceback" not in result.output


def test_one_thing_is_asked_of_it_at_a_time(tmp_path: Path) -> None:
    path = tmp_path / "study.toml"
    path.write_text("")
    assert run("protocol", "--check", path, "--markdown").exit_code == 2


def test_the_start_tells_the_experimenter_much_and_not_the_condition(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    protocol = protocol_from({"agent": {"scheme": "annealed"}, "trainer": {"mistake_rate": 0.5}}, to_run=True)
    source = {"credit": "rule", "credit_rule": "previous", "credit_asked_by": "protocol"}
    tell_start(protocol, source, tmp_path, "P01")
    told = capsys.readouterr().out
    for part in ("10 watched", "50 in all", "about 17 minutes", "previous (rule, asked for by the protocol)"):
        assert part in told
    assert "[trainer] mistake_rate has no effect here" in told
    assert "annealed" not in told
    # What is left out or comes later is named, with where it is said.
    words = " ".join(told.split())
    assert "Weight F2 on the first page says it, before the participant looks" in words
    assert "Compiled the kernels of tetris" in words
    assert "Reach said on the first screen" in words


def test_the_start_tells_the_weight_where_the_participant_may_see_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    tables: dict[str, object] = {"agent": {"scheme": "annealed"}, "screen": {"show_weight": True}}
    source = {"credit": "rule", "credit_rule": "previous", "credit_asked_by": "protocol"}
    tell_start(protocol_from(tables, to_run=True), source, tmp_path, "P01")
    assert "Weight    annealed" in capsys.readouterr().out


def start(
    monkeypatch: pytest.MonkeyPatch, folder: Path, text: str, *more: str
) -> tuple[Result, list[Protocol], list[object]]:
    """Run `arl play` up to the moment in which the app would start."""
    path = folder / "study.toml"
    path.write_text(text)
    protocols: list[Protocol] = []
    sources: list[object] = []

    def run_live(protocol: Protocol, *, source: object, **_: object) -> SessionOutcome:
        protocols.append(protocol)
        sources.append(source)
        return SessionOutcome(None, Tally())

    monkeypatch.setattr(play, "need_terminal", lambda *_, **__: None)
    monkeypatch.setattr(play, "run_live", run_live)
    result = run("play", "tetris", "--protocol", path, "--recordings", folder, *more)
    return result, protocols, sources


def test_what_is_told_before_the_app_starts_is_what_the_header_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = 'name = "arm B"\ndelay_of = "feedback-lag"\ndelay_if_missing = "paper"\n[trainer]\nmistake_rate = 0.5\n'  # noqa: E501
    result, (protocol,), (source,) = start(monkeypatch, tmp_path, text, "--participant", "P09")
    assert result.exit_code == 0, result.output
    told = " ".join(result.output.split())
    assert "Credit gamma:2.5,0.3 (paper, asked for by the protocol); P09 has no measured delay: paper" in told
    assert "Beware [trainer] mistake_rate has no effect here" in told
    assert "arm B" not in told  # the participant may read it
    assert protocol.agent.credit.delay == GammaDelay()
    assert protocol.delay_of == "rule"
    assert source == {
        "credit": "paper",
        "credit_rule": "gamma:2.5,0.3",
        "credit_asked": "feedback-lag",
        "credit_missing": "P09 has no measured delay: paper",
        "credit_asked_by": "protocol",
    }


def test_a_live_session_has_no_others(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    result, protocols, _ = start(monkeypatch, tmp_path, "[[others]]\n")
    assert result.exit_code == 1
    assert "`others` are participants of simulated sessions" in result.output
    assert protocols == []


@pytest.mark.parametrize("rule", ["gamma:2.5,300", "uniform:200,800"])
def test_a_delay_of_minutes_is_refused_on_the_command_line_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, rule: str
) -> None:
    result, protocols, _ = start(monkeypatch, tmp_path, "", "--credit", rule)
    assert result.exit_code == 2
    assert "seconds is one that nobody means" in " ".join(result.output.split())
    assert protocols == []


@pytest.mark.jit
def test_a_what_if_names_what_has_no_effect_in_it(tmp_path: Path) -> None:
    recording, path = tmp_path / "P01-x.jsonl", tmp_path / "study.toml"
    simulate_session(demo_protocol("tetris"), 4, recording, software={})
    path.write_text("[screen]\ntick_ms = 150\n")
    result = run(
        "replay", recording, "--protocol", path, "--scheme", "human-only", "--games", 1, "--workers", 1
    )
    assert result.exit_code == 0, result.output
    assert "Beware: [screen] tick_ms has no effect here" in result.output
