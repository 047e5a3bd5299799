"""What a protocol file may say, and what it is told where it says something else."""

import contextlib
import math
from pathlib import Path

import msgspec
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from core.combination.config import SCHEMES, AgentConfig, Annealed, Coach
from core.configuration.catalogue import TAG, Kind, settings_of, tables_of
from core.configuration.reading import ConfigurationError, with_tables
from core.configuration.toml_places import places
from core.feedback.config import CreditConfig
from core.feedback.delays import GammaDelay, PreviousStep
from core.learners.cross_entropy_config import NoNoise
from core.learners.policy_gradient_config import PolicyGradientConfig
from core.recording.reader import read_recording
from core.recording.schema import to_plain
from core.session.protocol import DEFAULTS, Protocol, SessionConfig
from core.session.protocol_file import ProtocolError
from core.session.protocol_reading import load_protocol, protocol_from

GOLDEN = Path(__file__).resolve().parents[3] / "recordings" / "reference"
LISTS = {path for path, kind in tables_of(Protocol) if kind.base == "tables"}
TABLES = [(path, tag, kind.base) for path, kind in tables_of(Protocol) for tag in kind.structs or {}]


def load(folder: Path, text: str, game: str = "tetris") -> Protocol:
    path = folder / "study.toml"
    path.write_text(text)
    return load_protocol(path, game=game)


def refusal(folder: Path, text: str, game: str = "tetris") -> str:
    with pytest.raises(ProtocolError) as caught:
        load(folder, text, game)
    return str(caught.value)


# --- unknown keys -------------------------------------------------------------------------------------------


def test_every_table_of_every_type_is_walked() -> None:
    names = {".".join(path) for path, _, _ in TABLES}
    for table in ("agent.scheme", "agent.bootstrap.trust", "agent.credit.delay", "agent.human_model"):
        assert table in names
    for table in (
        "learner.noise",
        "trainer.delay",
        "others",
        "others.delay",
        "people",
        "people.delay.values",
    ):
        assert table in names
    assert {tag for path, tag, _ in TABLES if path == ("agent", "scheme")} == set(SCHEMES)


def type_with(path: tuple[str, ...], key: str) -> dict[str, str]:
    """Return the type of a table that has a key, as written in the table; {} where all types have it."""
    structs = next(kind.structs or {} for found, kind in tables_of(Protocol) if found == path)
    tags = [tag for tag, struct in structs.items() if key in settings_of(struct)]
    return {} if len(tags) == len(structs) else {TAG: tags[0]}


@pytest.mark.parametrize(("path", "tag", "base"), TABLES, ids=lambda value: str(value))
@pytest.mark.parametrize("game", ["tetris", "keepaway"])
def test_no_table_takes_a_foreign_key(game: str, path: tuple[str, ...], tag: str, base: str) -> None:
    inner: object = {"foreign_key": 1} | ({TAG: tag} if tag else {})
    for depth in range(len(path), 0, -1):
        if path[:depth] in LISTS:
            inner = [inner]
        if depth > 1:
            inner = {path[depth - 1]: inner} | type_with(path[: depth - 1], path[depth - 1])
    with pytest.raises(ConfigurationError, match=r"foreign_key = 1: there is no such key") as caught:
        protocol_from({path[0]: inner}, game=game)
    assert "$" not in str(caught.value)


def test_every_struct_refuses_foreign_keys_also_where_it_is_decoded_alone() -> None:
    for _, kind in tables_of(Protocol):
        for struct in (kind.structs or {}).values():
            assert struct.__struct_config__.forbid_unknown_fields, struct


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ('[agent.scheme]\ntype = "annealed"\nbeta0 = 0.3\n', ":3: [agent.scheme] beta0 = 0.3: .*`beta_0`"),
        ("[agent.scheme]\nbeta_0 = 0.3\n", ":2: .*`beta_0` belongs to the types \"annealed\""),
        ("[agent.scheme]\nbeta0 = 0.3\n", "did you mean `beta_0`, which belongs to type \"annealed\""),
        ('[agent.credit.delay]\ntype = "gamma"\nscale_ms = 300\n', ":3: .*did you mean `scale_s`"),
        ("[session]\npause_between_episodes_s = 3\n", "belongs to [screen]"),
        ("[learner.noise]\nstrat = 3\n", ":2: [learner.noise] strat = 3: .*did you mean `start`"),
        ("episodes = 3\n", ":1: episodes = 3: .*[session]"),
        ("[[others]]\n[[others]]\nburst_rat = 1\n", ":3: [others.2] burst_rat = 1: .*`burst_rate`"),
    ],
)  # fmt: skip
def test_a_foreign_key_is_told_where_it_belongs(tmp_path: Path, text: str, told: str) -> None:
    message = refusal(tmp_path, text)
    before, _, after = told.partition(".*")
    assert before in message
    assert after in message.partition(before)[2] + before


# --- values -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ('[session]\nepisodes = "2"\n', ':2: [session] episodes = "2": expected a whole number 1 to 10000'),
        ("[session]\nepisodes = 2.0\n", "without a decimal point"),
        ("[session]\nepisodes = true\n", "episodes = true: expected a whole number"),
        ('[screen]\npalette = "standart"\n', 'did you mean "standard"?'),
        ("[agent]\ncredit = 3\n", ":2: [agent] credit = 3: expected a table, [agent.credit]"),
        ("[keys]\nrepeat_delay_ms = [1]\n", "expected a list of 2, each a whole number 0 to 5000 millisec"),
        ("[keys]\nrepeat_delay_ms = [700, 200]\n", "expected the shortest delay first"),
        ("[trainer]\nmistake_rate = nan\n", "infinity and NaN are none"),
        ("[trainer]\nburst_interval_s = inf\n", "> 0".replace("> 0", "infinity and NaN are none")),
        ('[keys]\ngood = "f"\n', ':2: [keys] good = "f": good, bad and retract need three different keys'),
        ('[agent.credit]\nsilence = "zero-label"\n', ":2: [agent.credit] silence"),
        ("others = 3\n", ":1: others = 3: expected a list of tables, each under [[others]]"),
    ],
)  # fmt: skip
def test_a_wrong_value_is_told_with_place_and_what_is_allowed(tmp_path: Path, text: str, told: str) -> None:
    message = refusal(tmp_path, text)
    assert told in message
    assert message.startswith(str(tmp_path / "study.toml") + ":")
    for ugly in ("$", "('", "',)", "`float`", "`int`"):
        assert ugly not in message


def test_all_that_is_wrong_is_told_at_once_in_the_order_of_the_file(tmp_path: Path) -> None:
    message = refusal(tmp_path, "name = 3\n\n[session]\nepisodes = 0\nwatched_step = 2\n")
    assert [line.split(": ")[0].rsplit(":")[-1] for line in message.splitlines()[:3]] == ["1", "4", "5"]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ('[agent.credit.delay]\ntype = "gamma"\nscale_s = 300\n', "300 seconds is a value that nobody means"),
        ('[agent.credit.delay]\ntype = "gamma"\nscale_s = 300\n', "in milliseconds it would be 0.3"),
        ('[agent.credit.delay]\ntype = "gamma"\nshape = 250.0\nscale_s = 3\n', "a mean delay of 750 seconds"),
        ('[agent.credit.delay]\ntype = "uniform"\nlow_s = 200\nhigh_s = 800\n', "200 seconds is a value"),
        ("[trainer.delay]\nscale_s = 300\n", "[trainer.delay] scale_s = 300"),
        ("[agent.credit]\nmerge_within_s = 300\n", "300 seconds is a value that nobody means"),
        ('[agent.human_model]\ntype = "sgd"\nstep_size = 2.0\n', "2 is a value that nobody means"),
        ('[agent.human_model]\ntype = "sgd"\nstep_size = 0.02\n', "diverge to infinity"),
        ("[trainer]\nstops_after_episodes = 1" + "0" * 400 + "\n", "expected a whole number 0 to 1000000000"),
        ("[keys]\nrefractory_ms = 1" + "0" * 400 + "\n", "expected a whole number 0 to 2000 milliseconds"),
        ("[trainer]\nmistake_rate = 1" + "0" * 400 + "\n", "expected a number 0 to 1"),
        ('[agent.human_model]\nl2 = 1e-300\nstandardise = false\n', "expected a number 1e-06 to 1000000"),
        ('[learner]\npopulation = 1000000000\n', "expected a whole number 2 to 10000 policies"),
        ('[domain]\ntype = "keepaway"\nlength_m = 1e6\n', "expected a number 10 to 120 metres"),
        ('[domain]\ntype = "keepaway"\n[learner]\nstep_size = 1e9\n', "expected a number 0 to 1"),
        ('[domain]\nlines_in_value = true\n', ":2: [domain] lines_in_value"),
        ('agent.scheme = "reward-shaping"\n', "reward-shaping needs a learner that learns at every step"),
        ('agent.scheme = "q-augmentation"\n', "q-augmentation needs a learner of action values"),
        ('agent.scheme = "coach"\n', "coach needs a learner with a softmax policy"),
        ('domain = "keepaway"\nagent.scheme = "coach"\n', "coach needs a learner with a softmax policy"),
        ('learner = "policy-gradient"\nagent.scheme = "coach"\n', 'set watched = "proposed"'),
        ('domain = "keepaway"\n[trainer]\nknowledge = "myopic"\n', "no participant of Keepaway is myopic"),
    ],
)  # fmt: skip
def test_what_would_end_in_nonsense_is_refused_when_it_is_read(tmp_path: Path, text: str, told: str) -> None:
    assert told in refusal(tmp_path, text)


def written_out(path: tuple[str, ...], tag: str) -> dict[str, object]:
    inner: object = {TAG: tag}
    for key in reversed(path):
        inner = {key: inner}
    assert isinstance(inner, dict)
    return inner


def test_a_type_alone_stands_for_its_table_with_the_defaults(tmp_path: Path) -> None:
    protocol = load(
        tmp_path,
        'domain = "tetris"\n[agent]\nscheme = "annealed"\n[agent.credit]\ndelay = "gamma"\n[learner]\nnoise = "none"\n',  # noqa: E501
    )
    assert protocol.agent.scheme == Annealed()
    assert protocol.agent.credit.delay == GammaDelay()
    assert msgspec.structs.asdict(protocol.learner)["noise"] == NoNoise()
    for path, kind in tables_of(Protocol):
        for tag in kind.structs or {}:
            if tag and not any(path[:depth] in LISTS for depth in range(1, len(path))):
                inner: object = tag
                for key in reversed(path):
                    inner = {key: inner}
                assert isinstance(inner, dict)
                # Some types do not go together with the rest of the protocol: that is no fault of the table's
                # form.
                with contextlib.suppress(ConfigurationError):
                    protocol_from(inner)
                assert with_tables(inner, Protocol) == with_tables(written_out(path, tag), Protocol)


# --- files --------------------------------------------------------------------------------------------------


def test_a_byte_order_mark_and_windows_line_ends_are_no_fault(tmp_path: Path) -> None:
    path = tmp_path / "study.toml"
    path.write_bytes(b'\xef\xbb\xbfname = "pilot"\r\n[session]\r\nepisodes = 2\r\n')
    assert load_protocol(path).session.episodes == 2
    path.write_bytes(b'\xef\xbb\xbfname = "pilot"\r\n[session]\r\nepisode = 2\r\n')
    with pytest.raises(ProtocolError, match=r"study\.toml:3: \[session\] episode"):
        load_protocol(path)


@pytest.mark.parametrize(
    ("content", "told"),
    [
        ('name = "Käthe"\n'.encode("latin-1"), "0xe4 in line 1"),
        ('name = "x"\n'.encode("utf-16"), "it is UTF-16"),
    ],
)
def test_a_file_that_is_not_utf_8_is_told_how_to_become_it(tmp_path: Path, content: bytes, told: str) -> None:
    path = tmp_path / "study.toml"
    path.write_bytes(content)
    with pytest.raises(ProtocolError, match=told) as caught:
        load_protocol(path)
    assert "Save it as UTF-8" in str(caught.value)


@pytest.mark.parametrize("text", ["x = " + "[" * 3000 + "]" * 3000, "x = " + "{a=" * 500 + "1" + "}" * 500])
def test_deep_nesting_is_refused(tmp_path: Path, text: str) -> None:
    assert "study.toml" in refusal(tmp_path, text)


def test_a_huge_file_is_not_read(tmp_path: Path) -> None:
    assert "at most 1000000 bytes" in refusal(tmp_path, "#" * 1_000_001)


def test_lines_are_found_in_every_way_of_writing_toml() -> None:
    text = 'a = 1\n"b" = """\nc = 2\n"""\n[d.e]\nf.g = 3\nh = { i = 4, j = 5 }\n[[k]]\nl = 6\n[[k]]\n  m = [\n  7,\n]\n'  # noqa: E501
    found = places(text)
    expected = {("a",): 1, ("b",): 2, ("d", "e"): 5, ("d", "e", "f", "g"): 6, ("d", "e", "h", "j"): 7}
    expected |= {("k", 0, "l"): 9, ("k", 1): 10, ("k", 1, "m"): 11}
    assert expected.items() <= found.items()
    assert ("c",) not in found


def test_messages_hold_nothing_that_a_terminal_obeys(tmp_path: Path) -> None:
    message = refusal(tmp_path, '"\\u001b[2J" = "\\u001b]0;title\\u0007"\n[screen]\npalette = "\\u009b31m"\n')
    assert all(letter.isprintable() or letter == "\n" for letter in message)


PLAIN = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8) | st.sampled_from(sorted(SCHEMES)),  # noqa: E501
    lambda inner: st.lists(inner, max_size=3)
    | st.dictionaries(
        st.sampled_from(["type", "scheme", "delay", "agent", "credit", "noise", "episodes", "shape"]) | st.text(max_size=5),  # noqa: E501
        inner,
        max_size=4,
    ),
    max_leaves=12,
)  # fmt: skip


@given(st.dictionaries(st.sampled_from(sorted(settings_of(Protocol))), PLAIN, max_size=4), st.booleans())
@settings(max_examples=300, deadline=None)
def test_whatever_a_protocol_says_the_answer_is_a_protocol_or_the_documented_error(
    plain: dict[str, object], to_run: bool
) -> None:
    with contextlib.suppress(ConfigurationError):  # any other error fails the test
        protocol = protocol_from(plain, to_run=to_run)
        assert protocol_from(to_plain(protocol)) == protocol


# --- what was once run --------------------------------------------------------------------------------------


@pytest.mark.parametrize("path", sorted(GOLDEN.glob("*.jsonl")), ids=lambda path: path.stem)
def test_headers_of_the_golden_recordings_can_be_read(path: Path) -> None:
    header = read_recording(path).header
    assert to_plain(protocol_from(header.protocol))["agent"]["scheme"] == header.protocol["agent"]["scheme"]


def test_a_recording_made_with_what_is_refused_today_can_still_be_read() -> None:
    slow = Protocol(agent=AgentConfig(credit=CreditConfig(delay=GammaDelay(scale_s=300.0))))
    deaf = Protocol(learner=PolicyGradientConfig(), agent=AgentConfig(scheme=Coach()))
    for protocol in (slow, deaf):
        assert protocol_from(to_plain(protocol)) == protocol
        with pytest.raises(ConfigurationError):
            protocol_from(to_plain(protocol), to_run=True)


def test_a_header_that_asks_for_the_impossible_is_refused_with_bounds_and_units() -> None:
    for table, told in (
        ({"learner": {"population": 10**9}}, "1 to 100000 policies"),
        ({"domain": {"type": "keepaway", "length_m": 1e6}}, "10 to 200 metres"),
        ({"session": {"unseen_between": 10**12}}, "0 to 10000000 episodes"),
        (
            {"agent": {"credit": {"delay": {"type": "gamma", "shape": 1e300}}}},
            "a number > 0 and <= 1000000000",
        ),
        ({"agent": {"bootstrap": {"top_policies": 10**9}}}, "1 to 100000 policies"),
    ):
        with pytest.raises(ConfigurationError) as caught:
            protocol_from(table)
        assert told in str(caught.value)


def test_every_number_has_a_range_whose_default_is_inside_it_and_usual() -> None:
    def check(kind: Kind, value: object) -> None:
        for item in kind.items:
            check(item, None)
        if kind.base in ("number", "whole number"):
            bounds = kind.range
            assert any(bound is not None for bound in (bounds.ge, bounds.gt)), kind
            if isinstance(value, int | float):
                assert bounds.holds(value)
                assert bounds.is_usual(value)
                assert math.isfinite(value)

    for _, kind in tables_of(Protocol):
        for struct in (kind.structs or {}).values():
            for setting in settings_of(struct).values():
                check(setting.kind, setting.default)
    for protocol in DEFAULTS.values():
        assert protocol_from(to_plain(protocol), game=protocol.game, to_run=True) == protocol


def test_every_setting_has_a_description() -> None:
    structs = [Protocol, *(s for _, kind in tables_of(Protocol) for s in (kind.structs or {}).values())]
    assert [
        f"{struct.__name__}.{setting.key}"
        for struct in structs
        for setting in settings_of(struct).values()
        if not setting.doc
    ] == []


def test_what_is_left_out_has_the_default_of_the_game() -> None:
    assert protocol_from({"session": {"episodes": 3}}, game="keepaway").session == SessionConfig(
        episodes=3, unseen_between=0, watched_steps=1200, unseen_steps=12000
    )
    assert protocol_from({}).agent.credit.delay == PreviousStep()


LINES = (
    "[agent]", "[agent.scheme]", "[learner]", "[session]", "[[others]]", "[agent.credit.delay]", 'type = "gamma"',  # noqa: E501
    'type = "keepaway"', 'scheme = "coach"', "beta_0 = inf", "shape = 1e300", "episodes = 2", "others = [{}]", "x = [[",  # noqa: E501
    "a.b.c = 1", '"\u00e9" = 1', "d = 1979-05-27", "see_phases = [9]", "= 3", 'delay = "uniform"', "noise = 3",  # noqa: E501
)  # fmt: skip


@given(st.lists(st.sampled_from(LINES), max_size=7), st.binary(max_size=3), st.sampled_from(sorted(DEFAULTS)))
@settings(max_examples=300, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_whatever_a_file_holds_the_answer_is_a_protocol_or_the_documented_error(
    tmp_path: Path, lines: list[str], noise: bytes, game: str
) -> None:
    path = tmp_path / "study.toml"
    path.write_bytes("\n".join(lines).encode() + noise)
    with contextlib.suppress(ProtocolError):  # any other error fails the test
        load_protocol(path, game=game)
