"""Rows of one session that come in great numbers: steps, presses, credit, frames, questions."""

import json
from collections.abc import Iterator

from core.events import (
    CreditGiven,
    EpisodeStarted,
    FocusLost,
    FocusRegained,
    FrameShown,
    KeyPressed,
    QuestionAnswered,
    QuestionPosed,
    Resumed,
    ScreenCleared,
    StepTaken,
    StopAsked,
    TimeGap,
    WrongPressAsked,
)
from studies.exports.columns import Row
from studies.exports.session_rows import OnScreen, SessionRows, between, step_actor, time_of
from studies.exports.words import action_of

_NEVER = OnScreen()
_INTERRUPTIONS = (ScreenCleared, Resumed, TimeGap, FocusLost, FocusRegained, WrongPressAsked, StopAsked)


def step_rows(session: SessionRows) -> Iterator[Row]:
    """Yield the rows of `steps`."""
    presses: dict[int, int] = {}
    feedback: dict[int, float] = {}
    for row in credit_rows(session):
        if row["counted"]:
            step = int(row["step_index"] or 0)
            presses[step] = presses.get(step, 0) + 1
            feedback[step] = feedback.get(step, 0.0) + float(row["feedback"] or 0.0)
    credited = session.recording.header.origin != "imported"
    for step, taken in session.steps.items():
        got: Row = {
            "presses_credited": presses.get(step, 0) if credited else None,
            "feedback": feedback.get(step, 0.0) if credited else None,
        }
        yield {**_step_row(session, taken), **got}


def _step_row(session: SessionRows, taken: StepTaken) -> Row:
    seen, place, detail = session.on_screen.get(taken.step, _NEVER), session.places[taken.step], taken.detail
    known = taken.human_action >= 0
    return {
        **session.keys,
        "game": place.game,
        "step": place.step,
        "step_index": taken.step,
        "decided_s": session.seconds(taken.time_ns),
        "shown_s": session.seconds(seen.shown_ns),
        "hidden_s": session.seconds(seen.hidden_ns),
        "on_screen_s": between(0, seen.total_ns),
        "piece": session.piece(taken.step),
        "actor": step_actor(session.game, detail),
        "action": session.action(taken.step),
        "action_index": _index(taken.action),
        "environment_action_index": _index(taken.environment_action),
        "human_action_index": _index(taken.human_action),
        "agreed": taken.human_action == taken.environment_action if known else None,
        "orientation": detail["orientation"] + 1 if "orientation" in detail else None,
        "column": detail["column"] + 1 if "column" in detail else None,
        "cycle_index": detail.get("cycle"),
        "reward": taken.reward,
        "state_json": _state(taken),
    }


def _state(taken: StepTaken) -> str | None:
    state = taken.state if taken.state is not None else taken.observed
    return None if state is None else json.dumps(state)


def press_rows(session: SessionRows) -> Iterator[Row]:
    """Yield the rows of `presses`."""
    for press, pressed in session.presses.items():
        place = session.press_places[press]
        seen = session.on_screen.get(pressed.step, _NEVER)
        back = session.retracted.get(press)
        on_screen = pressed.step in session.steps
        started = session.started[place.game - 1] if place.game else None
        yield {
            **session.keys_of(pressed),
            "game": place.game,
            "step": place.step,
            "press_index": press,
            "step_index": pressed.step if on_screen else None,
            "time_s": session.seconds(pressed.time_ns),
            "since_shown_s": (
                between(seen.shown_ns, pressed.time_ns) if on_screen and seen.shown_ns is not None else None
            ),
            "since_frame_s": _since_frame(session, pressed),
            "key": pressed.key,
            "read_as": pressed.read_as or None,
            "layout": pressed.layout or None,
            "value": pressed.value,
            "judgement": _judgement(pressed.value),
            "verdict": pressed.verdict,
            "counted": session.counted(press),
            "retracted": None if back is None else back.reason,
            "retracted_s": None if back is None else session.seconds(back.time_ns),
            "asked_wrong": pressed.asked_wrong,
            "pressed_by": pressed.source,
            "person": pressed.person + 1 if pressed.person >= 0 else None,
            "frame_index": _index(pressed.frame),
            "piece": session.piece(pressed.step),
            "action": session.action(pressed.step),
            **_credited(session.credit.get(press)),
            "trust": None if started is None else started.trust,
            "weight": None if started is None else started.weight,
        }


def _judgement(value: float | None) -> str | None:
    if value is None:
        return None
    return "good" if value > 0 else "bad" if value < 0 else "neither"


def _since_frame(session: SessionRows, pressed: KeyPressed) -> float | None:
    flushed_ns = session.frames.get(pressed.frame)
    return None if flushed_ns is None else between(flushed_ns, pressed.time_ns)


def _credited(credit: CreditGiven | None) -> Row:
    names = "credited_step_index credited_share before_first in_gaps too_late merged_into_index"
    if credit is None:
        return {"credited_steps": 0, **dict.fromkeys(names.split())}
    best = max(range(len(credit.shares)), key=credit.shares.__getitem__, default=None)
    return {
        "credited_steps": len(credit.steps),
        "credited_step_index": None if best is None else credit.steps[best],
        "credited_share": None if best is None else credit.shares[best],
        "before_first": credit.before_first,
        "in_gaps": credit.in_gaps,
        "too_late": credit.too_late,
        "merged_into_index": credit.merged_into,
    }


def credit_rows(session: SessionRows) -> Iterator[Row]:
    """Yield the rows of `credit`."""
    for press, credit in session.credit.items():
        pressed = session.presses[press]
        value = pressed.value or 0.0
        for step, share in zip(credit.steps, credit.shares, strict=True):
            place, seen = session.places.get(step), session.on_screen.get(step, _NEVER)
            yield {
                **session.keys_of(pressed),
                "game": None if place is None else place.game,
                "step": None if place is None else place.step,
                "press_index": press,
                "step_index": step,
                "counted": session.counted(press),
                "value": value,
                "share": share,
                "feedback": value * share,
                "after_shown_s": None if seen.shown_ns is None else between(seen.shown_ns, pressed.time_ns),
                "after_hidden_s": None
                if seen.hidden_ns is None
                else between(seen.hidden_ns, pressed.time_ns),
                "piece": session.piece(step),
                "action": session.action(step),
            }


def frame_rows(session: SessionRows) -> Iterator[Row]:
    """Yield the rows of `frames`."""
    games, last_ns = 0, None
    for event in session.recording.events:
        if isinstance(event, EpisodeStarted):
            games += 1
        elif isinstance(event, FrameShown):
            place = session.place_of(event.step, games)
            yield {
                **session.keys,
                "game": place.game,
                "step": place.step,
                "frame_index": event.frame,
                "step_index": _index(event.step),
                "flushed_s": session.seconds(event.flushed_ns),
                "since_last_s": None if last_ns is None else between(last_ns, event.flushed_ns),
            }
            last_ns = event.flushed_ns


def interruption_rows(session: SessionRows) -> Iterator[Row]:
    """Yield the rows of `interruptions`."""
    games = 0
    for event in session.recording.events:
        if isinstance(event, EpisodeStarted):
            games += 1
        elif isinstance(event, _INTERRUPTIONS):
            gap = event if isinstance(event, TimeGap) else None
            yield {
                **session.keys,
                "game": games or None,
                "event": str(event.__struct_config__.tag),
                "time_s": session.seconds(time_of(event)),
                "reason": getattr(event, "reason", None),
                "stood_still_s": None if gap is None else between(gap.last_ns, gap.time_ns),
                "suspended_s": None if gap is None else between(0, gap.suspended_ns),
            }


def question_rows(session: SessionRows) -> Iterator[Row]:
    """Yield the rows of `questions`."""
    events = session.recording.events
    answers = {event.question: event for event in events if isinstance(event, QuestionAnswered)}
    for posed in (event for event in events if isinstance(event, QuestionPosed)):
        answer, place = answers.get(posed.question), session.places.get(posed.step)
        words = [action_of(session.game, detail) for detail in posed.details]
        taken = session.steps.get(posed.step)
        chosen = None if answer is None else _index(answer.chosen)
        yield {
            **session.keys,
            "game": None if place is None else place.game,
            "step": None if place is None else place.step,
            "question_index": posed.question,
            "step_index": posed.step,
            "options": len(posed.options),
            "options_json": json.dumps(posed.options),
            **{f"option_{n + 1}": words[n] if n < len(words) else None for n in range(3)},
            "disagreement": posed.disagreement,
            "answer": None if answer is None else answer.answer,
            "chosen_index": chosen,
            "chosen_option": None if chosen is None else posed.options.index(chosen) + 1,
            "followed": None if chosen is None or taken is None else taken.action == chosen,
            "posed_s": session.seconds(posed.time_ns),
            **_answered(session, answer),
        }


def _answered(session: SessionRows, answer: QuestionAnswered | None) -> Row:
    if answer is None:
        return dict.fromkeys(("press_index", "shown_s", "answered_s", "latency_s"))
    return {
        "press_index": _index(answer.press),
        "shown_s": session.seconds(answer.shown_ns),
        "answered_s": session.seconds(answer.time_ns),
        "latency_s": between(answer.shown_ns, answer.time_ns) if answer.press >= 0 else None,
    }


def _index(number: int) -> int | None:
    """Return a number of the recording; None for the -1 that says there is none."""
    return None if number < 0 else number
