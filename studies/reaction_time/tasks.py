"""The seven tasks: which stimuli a block shows and which keys answer them.

Memory search, visual search and recognition are the kind of task whose response times Hockley (1984) studied;
feedback lag is the delay that credit assignment needs. Each function returns unordered material for n trials.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from studies.reaction_time.protocol import NO, YES, Task, TaskConfig

CONSONANTS = "BCDFGHJKLMNPQRSTVWXZ"
GRID_ROWS, GRID_COLUMNS = 6, 12
_WORD_LINES = """
anchor apple arrow autumn badge barrel basket beach blanket bottle branch bridge brush bucket butter
button cabin candle carpet castle cellar chain cherry circle cloud copper corner cotton cradle curtain
desert dinner eagle engine fabric feather fence finger flower forest garden ginger glove hammer harbor
helmet honey island jacket kettle ladder lantern lemon letter marble meadow mirror mountain needle oven
paddle palace pebble pencil pepper pillow pocket rabbit ribbon river rocket saddle sailor shadow silver
spider spoon stable summer table temple ticket tiger timber tunnel valley velvet village violin wagon
wallet walnut whistle window winter
"""
WORDS = tuple(_WORD_LINES.split())
"""Concrete nouns of four to eight letters, none a form of another."""


class Material(NamedTuple):
    """What one trial shows and asks."""

    stimulus: str
    condition: str
    expected_keys: tuple[str, ...]
    study_items: tuple[str, ...] = ()


Maker = Callable[[TaskConfig, int, Sequence[str], np.random.Generator], list[Material]]
"""(configuration, trials, words studied for the block, generator) -> material in any order."""


def simple(config: TaskConfig, n: int, studied: Sequence[str], rng: np.random.Generator) -> list[Material]:
    """One stimulus, one key."""
    return [Material("X", "go", ("space",))] * n


def choice(config: TaskConfig, n: int, studied: Sequence[str], rng: np.random.Generator) -> list[Material]:
    """Arrow left or right, half each."""
    both = [Material("<<<", "left", (NO,)), Material(">>>", "right", (YES,))]
    return [both[i % 2] for i in range(n)]


def go_no_go(config: TaskConfig, n: int, studied: Sequence[str], rng: np.random.Generator) -> list[Material]:
    """Press at O, not at X."""
    n_go = round(config.go_rate * n)
    return [Material("O", "go", ("space",))] * n_go + [Material("X", "no-go", ())] * (n - n_go)


def memory_search(
    config: TaskConfig, n: int, studied: Sequence[str], rng: np.random.Generator
) -> list[Material]:
    """Remember some letters, then say whether the probe was among them (Sternberg 1966)."""
    found = []
    for size, present in _sizes_and_answers(config.set_sizes or (2, 4, 6), n):
        letters = rng.permutation(list(CONSONANTS))
        items = tuple(str(letter) for letter in letters[:size])
        probe = items[int(rng.integers(size))] if present else str(letters[size])
        found.append(Material(probe, _condition(present, size), (YES if present else NO,), items))
    return found


def visual_search(
    config: TaskConfig, n: int, studied: Sequence[str], rng: np.random.Generator
) -> list[Material]:
    """Find a T among Ls scattered on a grid."""
    found = []
    for size, present in _sizes_and_answers(config.set_sizes or (4, 8, 16), n):
        cells = rng.permutation(GRID_ROWS * GRID_COLUMNS)[:size]
        grid = np.full(GRID_ROWS * GRID_COLUMNS, " ")
        grid[cells] = "L"
        if present:
            grid[cells[0]] = "T"
        rows = [" ".join(row) for row in grid.reshape(GRID_ROWS, GRID_COLUMNS)]
        found.append(Material("\n".join(rows), _condition(present, size), (YES if present else NO,)))
    return found


def recognition(
    config: TaskConfig, n: int, studied: Sequence[str], rng: np.random.Generator
) -> list[Material]:
    """Say whether a word was in the list studied at the start of the block; half were."""
    new_words = [str(word) for word in rng.permutation([word for word in WORDS if word not in set(studied)])]
    old_words = [str(word) for word in rng.permutation(list(studied))]
    found = []
    for i in range(n):
        old = i % 2 == 0
        words = old_words if old else new_words
        found.append(Material(words[(i // 2) % len(words)], "old" if old else "new", (YES if old else NO,)))
    return found


def feedback_lag(
    config: TaskConfig, n: int, studied: Sequence[str], rng: np.random.Generator
) -> list[Material]:
    """Watch the real game and judge the next marked event; half of them are bad."""
    good, bad = {
        "tetris": ("good placement", "bad placement"),
        "keepaway": ("ball kept", "ball lost"),
    }[config.game]
    both = [Material(good, good, (YES,)), Material(bad, bad, (NO,))]
    return [both[i % 2] for i in range(n)]


MAKERS: dict[Task, Maker] = {
    "simple": simple,
    "choice": choice,
    "go/no-go": go_no_go,
    "memory search": memory_search,
    "visual search": visual_search,
    "recognition": recognition,
    "feedback lag": feedback_lag,
}
ALLOWED_KEYS: dict[Task, tuple[str, ...]] = {
    task: ("space",) if task in ("simple", "go/no-go") else (NO, YES) for task in MAKERS
}


def _sizes_and_answers(sizes: Sequence[int], n: int) -> list[tuple[int, bool]]:
    """Return set size and present/absent of n trials: all pairs equally often, up to what n leaves over."""
    pairs = [(size, present) for size in sizes for present in (True, False)]
    return [pairs[i % len(pairs)] for i in range(n)]


def _condition(present: bool, size: int) -> str:
    return f"{'present' if present else 'absent'}, set size {size}"
