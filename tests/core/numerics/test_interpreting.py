"""Python in the place of compiled code: the same bits, and nothing waits."""

import subprocess
import sys

import msgspec
import numpy as np
import pytest

from arl_tui.commands.demo import demo_protocol
from core.numerics.compiled import JIT_DISABLED
from core.numerics.interpreting import (
    CAN_INTERPRET,
    interpreting,
    note_ready,
)
from core.numerics.kernel_folder import is_ready
from core.numerics.softmax import drawn
from core.recording.reader import read_recording
from studies.demo import simulate_session

pytestmark = pytest.mark.skipif(
    not CAN_INTERPRET, reason="kernels are interpreted on Linux only, and not twice"
)


def without_chain(path):
    """Return the events of a recording; the header and the chain of digests hold the time of day."""
    recording = read_recording(path)
    return recording.outputs, recording.inputs


@pytest.mark.jit
@pytest.mark.parametrize("game", ["tetris", "keepaway"])
@pytest.mark.parametrize("seed", [3, 4])
def test_an_interpreted_session_is_the_compiled_one_bit_for_bit(tmp_path, game, seed):
    demo = demo_protocol(game)
    short = msgspec.structs.replace(demo.session, episodes=4, unseen_between=3, unseen_steps=400)
    protocol = msgspec.structs.replace(demo, session=short)
    with interpreting():
        first = simulate_session(protocol, seed, tmp_path / "interpreted.jsonl", software={})
    second = simulate_session(protocol, seed, tmp_path / "compiled.jsonl", software={})
    assert without_chain(first) == without_chain(second)


@pytest.mark.jit
def test_compiled_code_takes_over_in_the_middle_of_a_game():
    from core.keepaway.pitch import KeepawayConfig
    from core.keepaway.viewed_match import ViewedMatch

    def play(compiled_from: int) -> list[object]:
        match, frames = ViewedMatch(KeepawayConfig(), "hand", 9), []
        for cycle in range(120):
            if cycle < compiled_from:
                with interpreting():
                    frames.append(match.step())
            else:
                frames.append(match.step())
        return frames

    # In this order: what is compiled once is no longer interpreted.
    assert play(120) == play(60) == play(0)


IN_A_NEW_PROCESS = """
from core.numerics.interpreting import by_name, interpreting, progress
from core.tetris.afterstate import Tetris


def kernels_at_hand():
    return sum(len(kernel._parts) + len(kernel.overloads) for kernel in list(by_name.values()))


before = kernels_at_hand()
with interpreting():
    domain = Tetris()
    domain.choices(domain.initial(5))
assert kernels_at_hand() == before
far = progress()
assert 0 <= far.compiled <= far.needed
assert 0.0 <= far.fraction <= 1.0
assert far.needed > 5, far
"""


def test_interpreting_compiles_nothing_and_knows_what_it_needs():
    # In this process other tests may have compiled the kernels, and then Python stands in for nothing.
    done = subprocess.run(
        [sys.executable, "-c", IN_A_NEW_PROCESS], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.jit
def test_what_is_ready_is_known_by_the_files_of_its_kernels():
    assert not JIT_DISABLED
    assert not is_ready("nothing of this name")
    drawn(np.array([0.5, 0.5]), 2, 0.7)
    note_ready("a test")
    assert is_ready("a test")
