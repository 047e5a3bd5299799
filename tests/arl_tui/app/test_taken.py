"""What a press was taken for: the step that credit gives most, and where that step is to be seen."""

import numpy as np
import pytest

from arl_tui.app.taken import StepsShown
from arl_tui.games.tetris.renderer import TetrisRenderer
from core.events import FrameShown, KeyPressed, ScreenCleared
from core.feedback.assigner import CreditAssigner
from core.feedback.config import CreditConfig
from core.feedback.delays import CurrentStep, Delay, GammaDelay, PreviousStep, UniformDelay
from core.numerics.streams import stream
from core.tetris.afterstate import Tetris
from core.tetris.config import TetrisConfig
from tests.arl_tui.fakes import episode_started, step_taken

MS = 1_000_000


def press(time_ms: int) -> KeyPressed:
    return KeyPressed(press=0, time_ns=time_ms * MS, key="j", value=1.0, frame=0, step=0, verdict="accepted")


def shown(step: int, time_ms: int) -> FrameShown:
    return FrameShown(frame=step, step=step, flushed_ns=time_ms * MS)


def test_the_piece_that_last_landed() -> None:
    steps = StepsShown(PreviousStep())
    assert steps.taken_for(press(0)) == -1
    steps.note(shown(-1, 0))
    steps.note(shown(0, 100))
    assert steps.taken_for(press(200)) == -1  # nothing has landed yet
    steps.note(shown(1, 1000))
    steps.note(shown(1, 1200))
    assert steps.taken_for(press(1500)) == 0
    assert steps.taken_for(press(900)) == -1  # the key's own time counts, not its arrival
    steps.note(ScreenCleared(time_ns=2000 * MS, reason="pause"))
    assert steps.taken_for(press(2500)) == 1
    steps.note(shown(1, 3000))
    assert steps.taken_for(press(3100)) == 0
    steps.note(shown(-1, 4000))
    assert steps.taken_for(press(4100)) == 1


@pytest.mark.parametrize("rule", [PreviousStep(), CurrentStep(), GammaDelay(), UniformDelay(0.1, 0.9)])
def test_it_is_the_step_that_the_learner_credits_most(rule: Delay) -> None:
    rng = stream(5, "test")
    steps, assigner = StepsShown(rule), CreditAssigner(CreditConfig(delay=rule))
    time_ms, on_screen, judged = 0, -1, 0
    for number in range(300):
        time_ms += int(rng.integers(50, 900))
        kind = rng.integers(4)
        if kind == 0:
            steps.note(ScreenCleared(time_ns=time_ms * MS, reason="help"))
            if on_screen >= 0:
                assigner.step_hidden(on_screen, time_ms * MS)
            on_screen = -1
        elif kind == 1 and number:
            given = assigner.add_press(number, time_ms * MS, 1.0)
            taken = steps.taken_for(press(time_ms))
            if given.steps:
                best = max(given.shares)
                assert given.shares[given.steps.index(taken)] == pytest.approx(best, abs=1e-12)
                judged += 1
            else:
                assert taken == -1
        else:
            on_screen = number
            steps.note(shown(number, time_ms))
            assigner.step_shown(number, time_ms * MS, np.zeros(1))
    assert judged > 20


@pytest.mark.parametrize("seed", range(4))
def test_blocks_are_where_the_piece_is_while_the_next_one_falls(seed: int) -> None:
    """Also after rows have gone: the marked cells are the piece's own, settled ones."""
    config = TetrisConfig(rows=8, columns=5)
    game, stage = Tetris(config), TetrisRenderer(config)
    state = game.initial(seed)
    stage.begin(episode_started(seed=seed))
    rng = stream(seed, "test")
    last_piece = -1
    for step in range(40):
        if game.terminal(state):
            break
        allowed = np.flatnonzero(~game.choices(state).ruled_out)
        if len(allowed) == 0:
            break
        detail = game.action_record(state, int(rng.choice(allowed))).plain()
        before = stage.picture
        taken = step_taken(
            step, piece=detail["piece"], orientation=detail["orientation"], column=detail["column"]
        )
        ticks = stage.act(taken)
        if step:
            # type: ignore[union-attr]
            codes = np.frombuffer(ticks[0].view.codes(), np.uint8).reshape(8, 5)[::-1]
            blocks = stage.place_of(step - 1)
            gone = 4 - len(blocks)
            assert all(codes[row, column] & 15 == last_piece + 1 for row, column in blocks)
            assert gone == 0 or before.counts.lines > 0
        last_piece = detail["piece"]
        state = game.transition(state, game_action(game, state, detail)).next_state
    assert stage.place_of(10_000) == ()


def game_action(game: Tetris, state, detail: dict[str, int]) -> int:
    return next(
        action
        for action in range(len(game.choices(state).features))
        if game.action_record(state, action).plain() == detail
    )
