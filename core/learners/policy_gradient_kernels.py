"""Kernels of policy gradient: the score of a softmax, and one step of learning, for rows of features of any
task.
"""

import math
from typing import NamedTuple

import numpy as np

from core.numerics.arrays import Floats
from core.numerics.compiled import inner_kernel, kernel

BASELINE, STEPS = range(2)
"""Places in `Memory.numbers`: running mean reward; decisions of the episode so far."""
STEP_SIZE, TRACE_DECAY, BASELINE_RATE, ONLINE, NATURAL = range(5)
"""Places in `Memory.rates`; the last two are 1 for yes."""


class Memory(NamedTuple):
    """State of a learner with F weights, changed in place."""

    weights: Floats
    """theta of the scaled features, shape (F,)."""
    trace: Floats
    """Eligibility, shape (F,)."""
    gradient: Floats
    """Sum over the episode of (reward - baseline) times eligibility, shape (F,)."""
    fisher: Floats
    """Sum over the episode of the scores' outer products, shape (F, F)."""
    precondition: Floats
    """What a gradient is multiplied by: the identity, or the inverse Fisher matrix, shape (F, F)."""
    numbers: Floats
    """In the order of the constants above."""
    rates: Floats
    """In the order of the constants above."""


@inner_kernel
def fill_score(
    rows: Floats, gains: Floats, probabilities: Floats, n: int, action: int, reference: int, out: Floats
) -> None:
    """Write the gradient of log pi(action) by theta, for logits whose derivative by R of each action is its
    gain.

    Args:
        rows: phi(s, a), scaled, shape (>= n, F).
        gains: shape (>= n,).
        probabilities: of the actions, shape (>= n,).
        n: number of actions.
        action: the one taken.
        reference: action whose R is taken off every R before the gain is applied; -1 for none.
        out: written, shape (F,).
    """
    n_weights = len(out)
    for i in range(n_weights):
        out[i] = 0.0
    for other in range(n):
        if probabilities[other] > 0.0:
            factor = probabilities[other] * gains[other]
            for i in range(n_weights):
                origin = rows[reference, i] if reference >= 0 else 0.0
                out[i] += factor * (rows[other, i] - origin)
    for i in range(n_weights):
        origin = rows[reference, i] if reference >= 0 else 0.0
        out[i] = gains[action] * (rows[action, i] - origin) - out[i]


@kernel
def remember_score(memory: Memory, score: Floats) -> None:
    """Take the score of the decision just made, shape (F,), into the eligibility trace."""
    decay = memory.rates[TRACE_DECAY]
    for i in range(len(score)):
        memory.trace[i] = decay * memory.trace[i] + score[i]
    if memory.rates[NATURAL] != 0.0:
        for i in range(len(score)):
            for j in range(len(score)):
                memory.fisher[i, j] += score[i] * score[j]
    memory.numbers[STEPS] += 1.0


@kernel
def learn_from_reward(memory: Memory, reward: float) -> None:
    """Credit a reward, less the baseline, to the decisions in the trace; move the weights where that is
    on-line.
    """
    advantage = reward - memory.numbers[BASELINE]
    memory.numbers[BASELINE] += memory.rates[BASELINE_RATE] * advantage
    n_weights = len(memory.trace)
    for i in range(n_weights):
        memory.gradient[i] += advantage * memory.trace[i]
    if memory.rates[ONLINE] == 0.0:
        return
    move = memory.rates[STEP_SIZE] * advantage
    for i in range(n_weights):
        if memory.rates[NATURAL] == 0.0:
            memory.weights[i] += move * memory.trace[i]
        else:
            direction = 0.0
            for j in range(n_weights):
                direction += memory.precondition[i, j] * memory.trace[j]
            memory.weights[i] += move * direction


@kernel
def invert_positive(matrix: Floats, out: Floats) -> None:
    """Write the inverse of a symmetric positive definite matrix (its lower triangle counts), shape (F, F)."""
    n = len(matrix)
    lower = np.zeros((n, n))
    for i in range(n):
        for j in range(i + 1):
            value = matrix[i, j]
            for k in range(j):
                value -= lower[i, k] * lower[j, k]
            lower[i, j] = math.sqrt(value) if i == j else value / lower[j, j]
    column = np.empty(n)
    for at in range(n):
        for i in range(n):
            column[i] = 1.0 if i == at else 0.0
            for k in range(i):
                column[i] -= lower[i, k] * column[k]
            column[i] /= lower[i, i]
        for back in range(n):
            i = n - 1 - back
            for k in range(i + 1, n):
                column[i] -= lower[k, i] * column[k]
            column[i] /= lower[i, i]
        for i in range(n):
            out[i, at] = column[i]
