"""No text from a file reaches a terminal, a page or a figure as something that it obeys: a canary in every
field."""

import ast
import io
import json
import re
import unicodedata
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
from click.testing import CliRunner

from arl_tui.cli import main
from arl_tui.commands import play
from core.keepaway.pitch import KeepawayConfig
from core.keepaway.policy_file import PolicyHeader, _empty
from core.learners.sarsa_config import SarsaConfig
from core.recording.chain import Chain
from core.system.foreign_text import in_html, in_plot, printable_json
from tests.fuzz.targets import TAMER, recordings

ROOT = Path(__file__).resolve().parents[3]
CANARY = "\x1b]0;title\x07\x1b[2J\x9b31m\u202etxt.exe\u2066\x0d\x08"
"""Sets the window's title, clears the screen, colours by a C1 control, turns the order of reading, goes
back."""
COLOURS = re.compile(r"\x1b\[[0-9;]*m")
"""What `click.style` writes; the canary holds none of these."""


def printed(*arguments: str | Path) -> str:
    """Run a command as in a terminal with colours; return all that it prints, after a look at every
    character."""
    result = CliRunner().invoke(main, [str(argument) for argument in arguments], color=True)
    assert result.exception is None or isinstance(result.exception, SystemExit), result.exception
    assert_harmless(result.output)
    return result.output


def assert_harmless(text: str) -> None:
    plain = COLOURS.sub("", text)
    unsafe = {
        sign
        for sign in plain
        if sign != "\n" and not (sign.isprintable() or unicodedata.category(sign) == "Zs")
    }
    assert not unsafe, f"{unsafe!r} in {plain[:2000]!r}"


def places(value: Any, path: tuple = ()) -> Iterator[tuple]:
    """Yield where texts are in plain JSON: values, and keys of tables."""
    if isinstance(value, str):
        yield path
    elif isinstance(value, dict):
        for name, below in value.items():
            yield (*path, name)
            if not isinstance(below, str):
                yield from places(below, (*path, name))
    elif isinstance(value, list):
        for number, below in enumerate(value[:1]):
            yield from places(below, (*path, number))


def with_canary(line: dict, path: tuple, *, key: bool) -> dict:
    """Return a line with the canary as a value, or in a key."""
    changed = json.loads(json.dumps(line))
    below = changed
    for name in path[:-1]:
        below = below[name]
    if key and isinstance(below, dict):
        below[CANARY] = below.pop(path[-1])
    else:
        below[path[-1]] = CANARY
    return changed


def lines_of(content: bytes) -> list[dict]:
    lines = [json.loads(line) for line in content.splitlines()]
    for line in lines:
        line.pop("chain")
    return lines


def sealed(lines: list[dict]) -> bytes:
    chain = Chain()
    return b"".join(chain.seal(json.dumps(line, separators=(",", ":")).encode()) for line in lines)


def every_forgery() -> Iterator[bytes]:
    """Yield recordings with a canary in one field, for every field of the header and of one event of each
    kind."""
    lines = lines_of(recordings()[0])
    kinds: dict[str, int] = {}
    for number, line in enumerate(lines):
        kinds.setdefault(line["type"], number)
    for number in kinds.values():
        for path in places(lines[number]):
            for key in (False, True):
                yield sealed(
                    [*lines[:number], with_canary(lines[number], path, key=key), *lines[number + 1 :]]
                )


FORGERIES = list(every_forgery())


def test_the_canary_is_in_every_field():
    assert len(FORGERIES) > 100
    escaped = json.dumps(CANARY).encode()[1:-1]
    assert all(escaped in forgery for forgery in FORGERIES)


def test_recordings_are_listed_without_what_a_terminal_obeys(tmp_path):
    for number, forgery in enumerate(FORGERIES):
        (tmp_path / f"{number:04}.jsonl").write_bytes(forgery)
    (tmp_path / f"{CANARY.replace('/', '')}.jsonl").write_bytes(FORGERIES[0][:300])
    text = printed("recordings", "--recordings", tmp_path, "--csv", tmp_path / "table.csv")
    assert_harmless((tmp_path / "table.csv").read_text())
    assert "\\x1b]0;title\\x07" in text
    assert text.count("DAMAGED") > 10


def test_replay_prints_nothing_that_a_terminal_obeys(tmp_path):
    path = tmp_path / "forged.jsonl"
    for forgery in FORGERIES[:: max(1, len(FORGERIES) // 25)]:
        path.write_bytes(forgery)
        printed("replay", path)


def test_copies_tables_data_sets_and_comparisons_are_made_without_it(tmp_path):
    folder = tmp_path / "in"
    folder.mkdir()
    for number, forgery in enumerate(FORGERIES[:: max(1, len(FORGERIES) // 20)]):
        (folder / f"{number:04}.jsonl").write_bytes(forgery)
    printed("anonymise", folder, tmp_path / "copies", "--key", tmp_path / "key")
    printed("export", "tidy", folder, "--out", tmp_path / "tidy")
    printed("export", "bids", folder, "--out", tmp_path / "bids")
    plain, forged = tmp_path / "plain.jsonl", tmp_path / f"{CANARY.replace('/', '')}.jsonl"
    plain.write_bytes(recordings()[0])
    lines = lines_of(recordings()[0])
    lines[0]["participant"] = lines[0]["protocol"]["name"] = CANARY
    lines[0]["study"] = {"condition": CANARY, "name": CANARY}
    forged.write_bytes(sealed(lines))
    for by in ("participant", "condition", "protocol"):
        beside = tmp_path / "tidy" / f"compared-{by}"
        printed("compare", plain, forged, "--by", by, "--csv", f"{beside}.csv", "--html", f"{beside}.html")
        assert "x1b]0;title" in Path(f"{beside}.csv").read_text()
    tables = [path for made in ("tidy", "bids") for path in (tmp_path / made).rglob("*") if path.is_file()]
    assert len(tables) > 10
    for path in tables:
        assert_harmless(path.read_text(encoding="utf-8").replace("\t", ""))


def test_a_code_from_a_recording_never_becomes_a_path(tmp_path):
    lines = lines_of(recordings()[0])
    for code in ("../../etc/passwd", CANARY, "", "a" * 300, "/etc/passwd"):
        lines[0]["participant"] = code
        path = tmp_path / "forged.jsonl"
        path.write_bytes(sealed(lines))
        assert "a participant's code has up to 32" in " ".join(
            printed("replay", path, "--credit", "participant").split()
        )


def test_tables_of_others_are_fitted_and_drawn_without_it(tmp_path):
    table = tmp_path / "table.csv"
    rows = "".join(
        f'"{who}",{0.3 + n % 17 * 0.01},"{CANARY}$x$"\n'
        for n in range(60)
        for who in (CANARY, "<b>$a_b$</b>")
    )
    table.write_bytes(f'participant,rt,"{CANARY}"\n{rows}'.replace("\r", "").encode())
    page, figure = tmp_path / "page.html", tmp_path / "figure.svg"
    common = (
        "fit",
        table,
        "--column",
        "rt=rt",
        "--column",
        "participant=participant",
        "--unit",
        "s",
        "--goodness",
        "0",
        "--resamples",
        "0",
    )
    text = printed(*common, "--html", page, "--figure", figure, "--json", "-", "--workers", "1")
    assert "\\u001b" in text or "\\x1b" in text
    for made in (page, figure):
        written = made.read_text(encoding="utf-8")
        assert_harmless(written.replace("\t", ""))
        assert "<b>$a_b" not in written
    printed("fit", table, "--column", f"rt={CANARY}")
    printed("import", "evaluations", table, "--out", tmp_path / "out")


def test_imported_logs_and_their_presses(tmp_path):
    log = tmp_path / "log.log"
    log.write_bytes(TAMER.replace(b"params", CANARY.replace("\r", "").encode()))
    printed("import", "tamer-log", log, "--out", tmp_path / "in" / "log.jsonl")
    log.write_bytes(TAMER.replace(b":true:", f":{CANARY}:".replace("\r", "").encode()))
    printed("import", "tamer-log", log, "--out", tmp_path / "in" / "again.jsonl")
    table = tmp_path / "said.csv"
    table.write_text(
        f'participant_id,time_s,value,delay_s\n"{CANARY}",1.0,1,0.5\n"{CANARY}",3.0,-1,0.7\n'.replace(
            "\r", ""
        )
    )
    printed("import", "evaluations", table, "--out", tmp_path / "said")
    lines = lines_of((tmp_path / "in" / "log.jsonl").read_bytes())
    lines[0]["participant"] = CANARY
    lines[0]["source"] = {CANARY: CANARY, "format": CANARY, "condition": CANARY, "file": CANARY}
    forged = tmp_path / "in" / "forged.jsonl"
    forged.write_bytes(sealed(lines))
    printed("presses", forged, "--csv", tmp_path / "presses.csv")
    assert_harmless((tmp_path / "presses.csv").read_text())
    printed("fit", forged, "--goodness", "0", "--resamples", "0")


@pytest.mark.parametrize(
    "command", [("protocol", "--check"), ("study", "check"), ("study", "status"), ("study", "run")]
)
def test_settings_of_others_are_checked_without_it(tmp_path, command):
    escaped = json.dumps(CANARY)
    for text in (
        f"{escaped} = 1\n",
        f"name = {escaped}\n",
        f"[keys]\ngood = {escaped}\n",
        CANARY,
        f"[{escaped}]\na = 1\n",
    ):
        file = tmp_path / "settings.toml"
        file.write_text(text, encoding="utf-8", newline="")
        printed(*command, file)


def test_policies_of_others(tmp_path, monkeypatch):
    monkeypatch.setattr(play, "need_terminal", lambda *_, **__: None)
    header = PolicyHeader(
        task=KeepawayConfig(), learner=SarsaConfig(), n_tilings=1, root_seed=1, hours=0.1, episodes=3, duration_s=5.0,  # noqa: E501
        created_utc=CANARY, software={CANARY: CANARY},
    )  # fmt: skip
    for plain in (
        msgspec.to_builtins(header) | {CANARY: 1},
        msgspec.to_builtins(header) | {"format": CANARY},
    ):
        out = io.BytesIO()
        np.savez(
            out, header=np.frombuffer(json.dumps(plain).encode(), np.uint8), weights=_empty(header).weights
        )
        path = tmp_path / "policy.npz"
        path.write_bytes(out.getvalue())
        assert "\\x1b" in printed("watch", "keepaway", "--policy", path)


def test_delays_of_others(tmp_path):
    recording = tmp_path / "session.jsonl"
    recording.write_bytes(recordings()[0])
    code = lines_of(recordings()[0])[0]["participant"]
    (tmp_path / "participants").mkdir()
    for text in (
        json.dumps({CANARY: 1}),
        json.dumps({"participant": CANARY}),
        CANARY,
        json.dumps({"format": CANARY}),
    ):
        (tmp_path / "participants" / f"{code}.json").write_text(text)
        printed("replay", recording, "--credit", "participant")


def test_results_of_others(tmp_path):
    folder = tmp_path / "credit"
    folder.mkdir()
    record = {
        "experiment": CANARY,
        "quick": False,
        "conditions": {CANARY: CANARY},
        "software": [{CANARY: CANARY}],
    }
    for text in (json.dumps(record), CANARY, json.dumps({"experiment": "credit"})):
        (folder / "sweep.json").write_text(text)
        printed("experiment", "report", "credit", "--out", tmp_path)


def test_a_folder_of_such_a_name(tmp_path):
    folder = tmp_path / CANARY.replace("/", "")
    folder.mkdir()
    assert "\\x1b" in printed("recordings", "--recordings", folder)


def test_pages_figures_and_json_have_functions_of_their_own():
    assert in_html(f"<b>{CANARY}") == "&lt;b&gt;" + in_html(CANARY)
    assert_harmless(in_plot(CANARY))
    assert in_plot("$x$") == r"\$x\$"
    text = json.dumps({"a": CANARY, "b": "ü\U000e0001"}, ensure_ascii=False)
    assert json.loads(printable_json(text)) == json.loads(text)
    assert_harmless(printable_json(text))


def test_commands_print_through_one_function():
    """`say` of `arl_tui.command_line` is the only way: nothing else calls click's or Python's."""
    for path in sorted((ROOT / "arl_tui").rglob("*.py")):
        if path.name == "command_line.py":
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call):
                called = ast.unparse(node.func)
                assert called not in ("click.echo", "click.secho", "click.style", "print"), (
                    f"{path}:{node.lineno}: {called}"
                )
