"""The tables of Keepaway's fidelity page: rows replaced by hand, heads that the page has, and the command's
refusals."""

from pathlib import Path

import numpy as np
import pytest

from core.keepaway.training import LearningCurve
from studies.fidelity import __main__ as command
from studies.fidelity import curves_page, learning_table, regions
from studies.fidelity.ce_curves import CurvePoint
from studies.fidelity.keepaway_fidelity import FINE_NAMES, SETTINGS, TABLE_HEAD, fine_row
from studies.fidelity.keepaway_rollouts import Rollout
from studies.fidelity.page import FINE_HEAD, ROLLOUT_HEAD, PageError, rollout_rows, with_curves, with_rows
from tests.data_folder import data_root

PAGE = Path(__file__).resolve().parents[3] / "docs" / "results" / "keepaway_fidelity.md"


def test_rows_of_one_table_are_replaced_and_all_else_stays():
    page = (
        "Text.\n\n| a | b |\n| --- | --- |\n| 1 | 2 |\n| 3 | 4 |\n\nMore.\n\n| a | b |\n| --- | --- |\n| 5 | "
        "6 |\n"
    )
    changed = with_rows(page, ("a", "b"), [("7", ""), ("8", "9")], number=1)
    assert changed == page.replace("| 5 | 6 |", "| 7 |  |\n| 8 | 9 |")
    assert with_rows(page, ("a", "b"), [("1", "2"), ("3", "4")]) == page
    with pytest.raises(PageError, match="need 3 tables"):
        with_rows(page, ("a", "b"), [], number=2)


def test_the_page_has_every_table_that_is_written():
    page = PAGE.read_text(encoding="utf-8")
    others = ((learning_table.HEAD, 0), (regions.HEAD, 0))
    for head, number in ((TABLE_HEAD, 0), (TABLE_HEAD, 1), (FINE_HEAD, 0), (ROLLOUT_HEAD, 0), *others):
        assert "| new |" in with_rows(page, head, [("new",)], number=number)


def test_a_missed_target_is_bold():
    reference = dict.fromkeys(FINE_NAMES, 2.0)
    row = fine_row(SETTINGS[0], {**reference, "flight cycles": 2.22}, reference)
    assert row[2:] == (
        "2.00 / 2.00 (+0 %)",
        "2.00 / 2.00 (+0 %)",
        "2.22 / 2.00 **(+11 %)**",
        "2.00 / 2.00 (+0 %)",
    )


def test_starts_are_rows_and_who_has_the_ball_columns():
    found = [
        Rollout("taker", 177, 1, "both", 46, 42.4, 1.44),
        Rollout("drop", 448, 1, "keeper", 73, 70.0, 1.2),
        Rollout("drop", 448, 1, "ended", 5, 6.0, -0.04),
    ]
    assert rollout_rows(found) == [
        ("9 cycles after a drop (448)", "1", "73 (70, +1.2)", "", "", "", "5 (6, -0.0)"),
        ("only takers can (177)", "1", "", "46 (42, +1.4)", "", "", ""),
    ]


def test_without_data_the_command_says_what_to_set(monkeypatch, capsys):
    monkeypatch.delenv("ARL_DATA", raising=False)
    with pytest.raises(SystemExit) as stopped:
        command.main([])
    assert stopped.value.code == 2
    assert "Set ARL_DATA, or give --data" in capsys.readouterr().err


def test_check_writes_nothing_and_fails_where_a_table_differs(monkeypatch, capsys, tmp_path):
    page = tmp_path / "page.md"
    page.write_text("as it was\n", encoding="utf-8")
    monkeypatch.setattr("studies.fidelity.page.renewed", lambda before, *_: before.replace("was", "is"))
    arguments = [str(page), "--data", str(tmp_path)]
    assert command.main([*arguments, "--check"]) == 1
    assert page.read_text(encoding="utf-8") == "as it was\n"
    assert "+as it is" in capsys.readouterr().out
    assert command.main(arguments) == 0
    assert page.read_text(encoding="utf-8") == "as it is\n"
    assert command.main([*arguments, "--check"]) == 0
    assert "every table is as it was" in capsys.readouterr().out


def curve(*means: float) -> LearningCurve:
    """Return a run whose blocks have these means."""
    durations = np.repeat(means, learning_table.BLOCK)
    return LearningCurve(durations, np.zeros(len(durations), np.bool_))


def test_learning_is_told_by_blocks_and_the_last_says_how_many_reach_it():
    seeds = [curve(1.0, 4.0), curve(2.0, 5.0), curve(3.0)]
    runs = [curve(float(k), 4.0) for k in range(1, 10)] + [curve(10.0)]
    first, last = learning_table.learning_rows(seeds, runs, curve(7.5, 9.0))
    # Means 1, 2, 3: 2 +- t(0.975, 2 d.f.) * 1 * sqrt(1 + 1/3) = 2 +- 4.303 * 1.155.
    assert first[:3] == ("1-500", "1.00 - 2.00 - 3.00", "-3.0 - 7.0")
    assert first[3:] == ("5.50 [1.23, 9.78]", "7.50", "3 of 10")
    assert last == ("501-1000", "4.00 - 4.50 - 5.00 (two)", "", "4.00 [4.00, 4.00] (9)", "9.00", "")


def test_the_tasks_of_the_page_are_those_that_are_played():
    page = PAGE.read_text(encoding="utf-8").split("## Other regions and numbers")[1].split("## Learning")[0]
    rows = [line.split("|")[1].strip() for line in page.splitlines() if line.startswith("|")][2:]
    assert rows == list(regions.TASKS)


def test_curves_are_medians_beside_the_published_range():
    ours = [
        CurvePoint(rules, "none", 0, k, 250.4)
        for rules in curves_page.SHOWN_RULES
        for k in (1, 3, 5, 10, 15, 20)
    ]
    published = [
        CurvePoint("published", "none", run, k, lines)
        for run, lines in enumerate((0.25, 99.96, 12345.0))
        for k in (1, 3, 5, 10, 15, 20)
    ]
    rows = curves_page.curve_rows(ours, published)
    assert rows[0] == ("none", "1", "250", "250", "250", "0.2 · 100 · 12,345")
    assert len(rows) == 6


def test_the_page_of_curves_is_what_its_command_makes():
    published = data_root() / command.PUBLISHED
    if not published.exists():
        pytest.skip(f"no published curves at {published}: set ARL_DATA")
    root = PAGE.parents[2]
    page = root / command.CURVES_PAGE
    before = page.read_text(encoding="utf-8")
    assert with_curves(before, root / command.CURVES, published, None) == before
