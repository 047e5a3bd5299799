"""Questions of the agent in a recorded session."""

import numpy as np

from core.events import QuestionAnswered, QuestionPosed
from studies.session_view.session import SessionView


def question_near(session: SessionView, time_ns: int) -> tuple[QuestionPosed, QuestionAnswered | None] | None:
    """Return the newest question that had been posed by a time, and its answer; None where there is none.

    The answer is None where the recording ends before it. It may come after `time_ns`.
    """
    table = session.index.tables["questions"]
    row = int(np.searchsorted(table["time"], time_ns, side="right")) - 1
    if row < 0:
        return None
    posed = session.index.line(int(table["offset"][row]))
    assert isinstance(posed, QuestionPosed), "the index says so"
    offset = int(table["answer"][row])
    answer = session.index.line(offset) if offset >= 0 else None
    assert answer is None or isinstance(answer, QuestionAnswered), "the index says so"
    return posed, answer
