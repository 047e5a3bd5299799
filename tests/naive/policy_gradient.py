"""Policy gradient in plain numpy: slow, obvious, equal but for rounding."""

import numpy as np

from core.combination.config import ADVISE, EXPONENTIAL, LINEAR


def logits(env, human, w_h, form, open_):
    """f(R, H) of the open actions, R and H being arrays over them."""
    env, human = np.asarray(env, float)[open_], np.asarray(human, float)[open_]
    if w_h == 0:
        return env
    if form == LINEAR:
        if human.std() == 0:
            return env
        return env + w_h * max(1.0, env.std()) * (human - human.mean()) / human.std()
    if form == ADVISE:
        advice = w_h * (human - human.mean()) / human.std() if human.std() > 0 else np.zeros_like(human)
        return env + np.log(1 / (1 + np.exp(-advice)))
    if form == EXPONENTIAL:
        span = human.max() - human.min()
        share = (human - human.min()) / span if span > 0 else np.zeros_like(human)
        if w_h < 0:
            share = 1 - share
        return (env - env.min()) * (1 + share ** abs(w_h))
    return env + w_h * human


def probabilities(values):
    powers = np.exp(values - values.max())
    return powers / powers.sum()


class NaiveLearner:
    """GPOMDP and OLPOMDP with a running mean as baseline."""

    def __init__(self, n, *, step_size, trace_decay, baseline_rate, online):
        self.theta, self.trace, self.gradient = np.zeros(n), np.zeros(n), np.zeros(n)
        self.baseline = 0.0
        self.rates = step_size, trace_decay, baseline_rate, online

    def learn(self, score, reward):
        step_size, trace_decay, baseline_rate, online = self.rates
        self.trace = trace_decay * self.trace + score
        advantage = reward - self.baseline
        self.baseline += baseline_rate * advantage
        self.gradient = self.gradient + advantage * self.trace
        if online:
            self.theta = self.theta + step_size * advantage * self.trace
