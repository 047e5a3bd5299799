"""Kinds of environment learners, for settings. No numerical library is imported."""

from typing import Literal

LearnerKind = Literal["search", "climbing", "stepwise"]
"""What a learner does while an episode is played: "search", it waits for the performance of a whole policy
(`core.learners.contract.EnvironmentLearner`); "climbing", it moves a softmax policy (`Actor`); "stepwise", it
changes its values at every step (`StepwiseLearner`)."""
