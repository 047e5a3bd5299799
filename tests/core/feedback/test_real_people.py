"""Credit on logs of real people: nothing is lost, whatever their presses look like."""

import itertools
from pathlib import Path

import numpy as np
import pytest

from core.feedback.assigner import CreditAssigner, CreditConfig
from core.feedback.credit import Delay, parse_delay
from core.learners.human_config import RidgeModel, SgdModel
from core.learners.human_reward import HumanRewardModel
from core.recording.importers.tamer_rows import Row, TamerLogError, read_tamer_log
from tests.data_folder import data_folder

RULES = ["previous", "current", "uniform:0.2,0.8", "gamma:2.5,0.3", "gamma:2.0,0.28,0.2"]

Presses = list[tuple[int, float]]


def logs() -> list[tuple[str, list[Row], Presses]]:
    """Every Tetris log that is there: its name, its steps in order, its presses in order of time."""
    found = []
    for path in sorted(data_folder("tamer_tetris").glob("*.log")):
        rows = tetris_rows(path)
        if rows:
            presses = sorted({press for row in rows for press in row.presses})
            found.append((path.name, rows, presses))
    assert found, "no Tetris log in the data folder"
    return found


def tetris_rows(path: Path) -> list[Row]:
    try:
        _, episodes = read_tamer_log(path)
    except TamerLogError as error:
        if "another domain" in str(error):
            return []
        raise
    return [row for episode in episodes for row in episode]


def listened(rows: list[Row], presses: Presses, delay: Delay, **options: object) -> CreditAssigner:
    """Live through a log: a step is shown from its row's time on, a terminal row shows nothing."""
    assigner = CreditAssigner(CreditConfig(delay=delay, **options))  # type: ignore[arg-type]
    events: list[tuple[int, int, int]] = [(row.start_ns, 0, step) for step, row in enumerate(rows)]
    events += [(time_ns, 1, press) for press, (time_ns, _) in enumerate(presses)]
    on_screen = -1
    for time_ns, kind, number in sorted(events):
        if kind == 1:
            assigner.add_press(number, time_ns, presses[number][1])
        elif rows[number].board:
            heights = [float(column.bit_length()) for column in rows[number].board]
            assigner.step_shown(number, time_ns, np.array(heights))
            on_screen = number
        else:
            assigner.step_hidden(on_screen, time_ns)
    assigner.finish(max(time_ns for time_ns, _, _ in events))
    return assigner


@pytest.mark.parametrize("rule", RULES)
def test_every_press_of_real_people_is_accounted_for(rule: str) -> None:
    for name, rows, presses in logs():
        account = listened(rows, presses, parse_delay(rule)).account
        mass = account.credited + account.before_first + account.in_gaps
        assert account.presses == len(presses), name
        assert mass == pytest.approx(len(presses), abs=1e-6), name
        assert account.credited > 0.8 * len(presses), name


def test_both_schemes_give_real_presses_the_same_weight() -> None:
    for name, rows, presses in logs():
        sums = []
        for scheme in ("individual", "aggregate"):
            assigner = listened(rows, presses, parse_delay("gamma:2.5,0.3"), scheme=scheme)
            assert assigner.account.too_late == 0, name
            sums.append(sum(sample.weight * sample.label for sample in assigner.samples))
        assert sums[0] == pytest.approx(sums[1], abs=1e-6), name


def test_bursts_of_real_people_are_recognised() -> None:
    for name, rows, presses in logs():
        assigner = listened(rows, presses, parse_delay("previous"), merge_within_s=0.3)
        merged = sum(
            value == before_value and time_ns - before_ns <= 300_000_000
            for (before_ns, before_value), (time_ns, value) in itertools.pairwise(presses)
        )
        assert assigner.account.merged == merged, name
        assert assigner.account.presses == len(presses) - merged, name


@pytest.mark.parametrize("config", [SgdModel(), RidgeModel()])
def test_taking_a_real_press_back_equals_never_having_seen_it(config: SgdModel | RidgeModel) -> None:
    for name, rows, presses in logs():
        number = len(presses) // 2
        assigner = listened(rows, presses, parse_delay("gamma:2.5,0.3"))
        assigner.retract(number)
        kept = listened(rows, presses[:number] + presses[number + 1 :], parse_delay("gamma:2.5,0.3"))
        models = []
        for samples in (assigner.samples, kept.samples):
            model = HumanRewardModel(config, 10)
            model.fit(samples)
            models.append(model.state_bytes())
        assert models[0] == models[1], name
