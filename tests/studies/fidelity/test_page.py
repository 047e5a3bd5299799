"""The tables of Keepaway's fidelity page: rows replaced by hand, heads that the page has, and the command's
refusals."""

from pathlib import Path

import pytest

from studies.fidelity import __main__ as command
from studies.fidelity.keepaway_fidelity import FINE_NAMES, SETTINGS, TABLE_HEAD, fine_row
from studies.fidelity.keepaway_rollouts import Rollout
from studies.fidelity.page import FINE_HEAD, ROLLOUT_HEAD, PageError, rollout_rows, with_rows

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
    for head, number in ((TABLE_HEAD, 0), (TABLE_HEAD, 1), (FINE_HEAD, 0), (ROLLOUT_HEAD, 0)):
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
