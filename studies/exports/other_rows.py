"""Rows of answers (records of sittings) and of reaction trials."""

from collections.abc import Iterator

from studies.exports.columns import Row
from studies.exports.session_rows import between
from studies.lab.sitting_log import (
    ConsentAnswered,
    FileRecorded,
    QuestionAnswered,
    SittingHeader,
    SittingLine,
)
from studies.reaction_time.trial_log import TrialFile


def answer_rows(header: SittingHeader, lines: tuple[SittingLine, ...], session: str) -> Iterator[Row]:
    """Yield the rows of `answers`; the condition is that of the last block before the question.

    Args:
        header: of the sitting.
        lines: its other lines.
        session: name of the sitting in the tables.
    """
    condition: str | None = None
    for line in lines:
        first: Row = {
            "participant": header.participant,
            "session": session,
            "study": header.study,
            "condition": condition,
            "sitting": header.sitting + 1,
            "place": header.place + 1,
            "origin": "simulated" if header.simulated else "live",
            "attempt": header.attempt + 1,
        }
        match line:
            case FileRecorded(condition=name) if name:
                condition = name
            case ConsentAnswered():
                for statement, agreed in line.answers.items():
                    yield {
                        **first,
                        "timeline_step": line.step + 1,
                        "questionnaire": "consent",
                        "question": statement,
                        "answer": "yes" if agreed else "no",
                        **dict.fromkeys(("answer_number", "passed", "shown_s", "duration_s")),
                        "answered_s": between(header.started_ns, line.time_ns),
                    }
            case QuestionAnswered():
                yield {**first, **_answer(line, header.started_ns)}
            case _:
                pass


def _answer(line: QuestionAnswered, started_ns: int) -> Row:
    answer = line.answer
    return {
        "timeline_step": line.step + 1,
        "questionnaire": line.questionnaire,
        "question": line.question,
        "answer": None if answer is None else "; ".join(answer) if isinstance(answer, tuple) else str(answer),
        "answer_number": float(answer) if isinstance(answer, int | float) else None,
        "passed": line.passed,
        "shown_s": between(started_ns, line.shown_ns),
        "answered_s": between(started_ns, line.answered_ns),
        "duration_s": between(line.shown_ns, line.answered_ns),
    }


def trials_origin(trials: TrialFile) -> str:
    """Return who pressed in reaction trials: "live" or "simulated"."""
    # An anonymised copy keeps its clock, not all facts.
    return "simulated" if "simulated" in (trials.header.clock, trials.header.facts.get("origin")) else "live"


def trial_rows(trials: TrialFile, session: str) -> Iterator[Row]:
    """Yield the rows of `trials`."""
    config = trials.header.schedule.config
    began_ns = min((record.started_ns for record in trials.trials), default=0)
    for record in trials.trials:
        onset_ns = record.asked_ns if record.catch else record.flushed_ns
        yield {
            "participant": trials.header.participant,
            "session": session,
            "origin": trials_origin(trials),
            "task": record.task,
            "domain": config.game if record.task == "feedback lag" else None,
            "block": record.block + 1,
            "trial": record.trial + 1,
            "practice": record.practice,
            "catch": record.catch,
            "trial_condition": record.condition,
            "stimulus": record.stimulus or None,
            "expected_keys": " ".join(record.expected_keys) or None,
            "foreperiod_s": record.foreperiod_s,
            "started_s": between(began_ns, record.started_ns),
            "onset_s": None if onset_ns is None else between(began_ns, onset_ns),
            "key": record.key,
            "rt_s": record.rt_s,
            "status": record.status,
            "right_censored": record.status == "time-out",
            "early_presses": record.early_presses,
            "other_presses": record.other_presses,
            "frame_interval_s": (
                None if record.frame_interval_ns is None else between(0, record.frame_interval_ns)
            ),
            "time_out_s": record.time_out_s,
            "least_rt_s": config.least_rt_s,
            "comment": record.comment or None,
        }
