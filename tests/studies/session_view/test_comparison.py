"""Figures of sessions by hand, groups and pairs, and a page that is safe whatever the files say."""

import math
from html.parser import HTMLParser
from pathlib import Path

import msgspec
import numpy as np
import pytest

from core.events import StepTaken
from core.recording.reader import read_recording
from core.recording.recorder import LineWriter
from studies.session_view.comparison import (
    MEASURES,
    SessionFigures,
    differences_of,
    figures_of,
    game_rows,
    group_interval,
    groups_of,
    over_games,
)
from studies.session_view.comparison_page import draw_comparison, origins_note, write_page
from tests.studies.session_view.made import TETRIS, live_events, write

pytestmark = pytest.mark.jit


def made(participant: str, condition: str, performances: list[float], **changed: object) -> SessionFigures:
    n = len(performances)
    facts: dict = {
        "file": f"{participant}-{condition}.jsonl",
        "participant": participant,
        "condition": condition,
        "protocol": "default",
        "game": "tetris",
        "performances": np.array(performances),
        "steps": np.full(n, 20.0),
        "origin": "live",
        "good": np.arange(n, dtype=float),
        "bad": np.ones(n),
        "match": np.full(n, 0.5),
        "trust": np.linspace(0, 0.4, n),
        "weight": np.linspace(0, 0.4, n),
        "taken_back": 0,
        "refused": 1,
        "agreement": 0.6,
        "consistency": 1.5,
        "delay_s": 0.7,
        "own_delay_s": math.nan,
    }
    return SessionFigures(**(facts | changed))


def test_the_condition_of_a_study_makes_a_group_and_simulated_sessions_are_named(tmp_path: Path) -> None:
    path = write(tmp_path / "live.jsonl", live_events())
    live = figures_of(path)
    golden = read_recording(path)
    header = msgspec.structs.replace(golden.header, study={"condition": "annealed"}, origin="simulated")
    writer = LineWriter(tmp_path / "simulated.jsonl", header)
    for event in golden.events:
        writer.append(event)
    writer.close()
    simulated = figures_of(tmp_path / "simulated.jsonl")
    assert (simulated.group("condition"), simulated.origin, live.origin) == ("annealed", "simulated", "live")
    assert origins_note([live]) == ""
    assert "in 1 of 1 sessions a simulated participant" in origins_note([simulated])
    assert "People and simulated participants are compared" in origins_note([live, simulated])


def test_figures_of_a_session_are_those_of_its_events(tmp_path: Path) -> None:
    figures = figures_of(write(tmp_path / "live.jsonl", live_events()))
    assert figures.performances.tolist() == [2.0]
    assert (figures.good.tolist(), figures.bad.tolist()) == ([1.0], [0.0])
    assert (figures.taken_back, figures.refused) == (1, 1)
    assert figures.match.tolist() == [0.5]
    assert figures.weight.tolist() == [0.25]
    assert figures.delay_s == pytest.approx(0.38)


def test_agreement_is_credit_that_says_what_the_policy_says(tmp_path: Path) -> None:
    path = tmp_path / TETRIS.name
    path.write_bytes(TETRIS.read_bytes())
    recording = read_recording(TETRIS)
    steps = {event.step: event for event in recording.outputs if isinstance(event, StepTaken)}
    values = {event.press: event.value for event in recording.inputs if type(event).__name__ == "KeyPressed"}
    agreeing = total = 0.0
    for event in recording.outputs:
        if type(event).__name__ == "CreditGiven":
            for step, share in zip(event.steps, event.shares, strict=True):
                own = steps[step].action == steps[step].environment_action
                agreeing += share * (own == (values[event.press] > 0))
                total += share
    assert figures_of(path).agreement == pytest.approx(agreeing / total)


def test_conditions_are_paired_by_participant() -> None:
    sessions = [
        made("P1", "a", [1, 3]), made("P2", "a", [2, 2]), made("P3", "a", [9, 9]),
        made("P1", "b", [4, 6]), made("P2", "b", [5, 7]),
    ]  # fmt: skip
    groups = groups_of(sessions, "condition")
    found = {one.measure: one for one in differences_of(groups, "condition")}
    performance = found["performance"]
    assert (performance.group, performance.control, performance.pairs) == ("b", "a", 2)
    assert performance.interval is not None
    assert performance.interval.estimate == pytest.approx(((5 - 2) + (6 - 2)) / 2)


def test_participants_are_paired_by_game_and_others_are_not_compared() -> None:
    groups = groups_of([made("P1", "a", [1, 3, 5]), made("P2", "a", [2, 5])], "participant")
    found = {one.measure: one for one in differences_of(groups, "participant")}
    assert found["performance"].pairs == 2
    assert found["performance"].interval.estimate == pytest.approx(1.5)
    assert "consistency" not in found


def test_groups_without_a_common_participant_say_so() -> None:
    groups = groups_of([made("P1", "a", [1.0]), made("P2", "b", [2.0])], "condition")
    assert all(one.interval is None and one.pairs == 0 for one in differences_of(groups, "condition"))


def test_games_that_are_missing_are_left_out_of_means() -> None:
    rows = over_games([made("P1", "a", [1, math.nan, 5]), made("P2", "a", [3])], "performances")
    assert rows[0] == 2
    assert math.isnan(rows[1])
    assert rows[2] == 5
    assert group_interval([made("P1", "a", [math.nan])], "performance") is None


def test_rows_hold_every_game_and_empty_fields_for_what_is_not_known() -> None:
    rows = list(game_rows([made("P1", "a", [1, math.nan])], "participant"))
    assert [row["game"] for row in rows] == [1, 2]
    assert rows[1]["performance"] == ""
    assert rows[0]["session_own_delay_s"] == ""
    assert rows[0]["group"] == "P1"


class Tags(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.words: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        assert not any(name.startswith("on") for name, _ in attrs)

    def handle_data(self, data: str) -> None:
        self.words.append(data)


def test_text_from_files_cannot_do_anything_on_the_page(tmp_path: Path) -> None:
    evil = '<script>alert("x")</script>\x1b[2J\u202e'
    sessions = [made("P1", "a", [1.0]), made(evil, evil, [2.0], file=evil, protocol=evil)]
    groups = groups_of(sessions, "condition")
    write_page(tmp_path / "page.html", groups, list(differences_of(groups, "condition")), "condition")
    text = (tmp_path / "page.html").read_text()
    page = Tags()
    page.feed(text)
    assert "script" not in page.tags
    assert "\x1b" not in text
    assert "\u202e" not in text
    assert any('<script>alert("x")</script>' in word for word in page.words)
    assert set(page.tags) <= {
        "html",
        "head",
        "meta",
        "title",
        "style",
        "body",
        "h1",
        "h2",
        "p",
        "img",
        "table",
        "tr",
        "th",
        "td",
        "br",
    }


def test_a_figure_has_a_line_for_every_group() -> None:
    groups = groups_of([made("P1", "$a_1$", [1, 2]), made("P2", "b", [2, 1])], "condition")
    figure = draw_comparison(groups)
    figure.savefig(__import__("io").BytesIO(), format="png")  # a dollar sign is no mathematics
    assert len(figure.legends[0].get_texts()) == 2
    assert set(MEASURES) >= {"performance", "presses", "agreement", "consistency", "trust", "weight"}


def test_a_recording_of_version_1_has_figures_too(tmp_path: Path) -> None:
    old = TETRIS.parents[1] / TETRIS.name
    path = tmp_path / "old.jsonl"
    path.write_bytes(old.read_bytes())
    new = tmp_path / "new.jsonl"
    recording = read_recording(old)
    writer = LineWriter(new, msgspec.structs.replace(recording.header, version=2))
    for event in recording.events:
        writer.append(event)
    writer.finish()
    writer.abandon()
    one, other = figures_of(path), figures_of(new)
    for measure in MEASURES:
        assert one.value(measure) == pytest.approx(other.value(measure), nan_ok=True)
