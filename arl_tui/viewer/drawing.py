"""What the viewer draws of a moment: marks on the game, and the lines beside it."""

import numpy as np
from rich.style import Style

from arl_tui.viewer.boards import BLAMED, CANDIDATE, PRAISED, WHAT_IF, bar
from arl_tui.viewer.looks import Look
from arl_tui.viewer.panels import Detail, beside, press_line, strip_lines, thought_lines
from arl_tui.viewer.reading import Viewing
from arl_tui.viewer.rows import BOLD, DIM, Run
from arl_tui.viewer.timeline import clock_text
from core.keepaway.picture import PitchFrame
from core.system.foreign_text import printable
from core.tetris.picture import Snapshot
from studies.session_view.session import Moment
from studies.session_view.transport import Transport

NEAR_NS = 1_000_000_000
"""A tag is at hand within this time."""


def board_marks(
    viewing: Viewing, moment: Moment, look: Look, view: Snapshot
) -> dict[tuple[int, int], tuple[str, Style]]:
    """Return the share of credit on each block of a credited piece, and the ranks of candidates."""
    marks: dict[tuple[int, int], tuple[str, Style]] = {}
    strip, press = viewing.strip(moment.time_ns)
    if strip is not None and press is not None:
        style = PRAISED if press.value > 0 else BLAMED if press.value < 0 else CANDIDATE
        for row, level in enumerate(look.ids[: view.rows]):
            for column, step in enumerate(level):
                share = strip.shares.get(step, 0.0)
                if share >= 0.005:
                    whole = "++" if press.value > 0 else "--" if press.value < 0 else "00"
                    text = whole if share >= 0.995 else f"{share * 100:2.0f}"
                    marks[view.rows - 1 - row, column] = (text, style)
    if view.falling is not None and look.before is not None:
        for cell, mark in viewing.candidates(moment.step, look.before.columns).items():
            row, column = cell
            if row < view.rows:
                style = WHAT_IF if mark.endswith("'") else CANDIDATE
                marks.setdefault((view.rows - 1 - row, column), (f"{mark:<2}", style))
    return marks


def pitch_marks(viewing: Viewing, moment: Moment, view: PitchFrame) -> dict[int, tuple[str, Style]]:
    """Return a bar for each option: at the receiver, or for holding the ball at the one who decides."""
    return {
        player: (
            f"{bar(height)}{text}",
            CANDIDATE if chosen else Style(color="#c4cfc8", bgcolor="#12291d"),
        )
        for player, (height, text, chosen) in viewing.bars(moment.step).items()
        if player < len(view.players)
    }


def status_line(viewing: Viewing, transport: Transport, moment: Moment) -> list[Run]:
    """Return where the viewer is."""
    session = viewing.session
    state = "playing" if transport.playing else "paused "
    speed = f"x{transport.speed:g}" if transport.speed >= 1 else f"x1/{1 / transport.speed:g}"
    at = clock_text(moment.time_ns - session.start_ns)
    whole = clock_text(session.end_ns - session.start_ns)
    step = f"  step {int(session.steps['number'][moment.step])}" if moment.step >= 0 else ""
    games = f"  game {moment.game + 1}/{len(session.games)}" if moment.game >= 0 else ""
    tag = viewing.tags.near(moment.time_ns, NEAR_NS)
    note = f"  [{tag.tag}] {printable(tag.note, longest=40)}" if tag is not None else ""
    if viewing.whole is not None:
        # How long the session is, is not known yet. The line has 57 columns in a window of 80.
        reading = f"  reading the rest: {viewing.whole.share:.0%}"
        return [(f"{state} {at}", BOLD), (reading, DIM), (f"{games}{step}  {speed}", None), (note, BOLD)]
    return [
        (f"{state} {at}", BOLD),
        (f" of {whole}  {speed}", None),
        (f"{games}{step}", None),
        (note, BOLD),
    ]


def feedback_lines(viewing: Viewing, moment: Moment, width: int, *, roomy: bool) -> list[list[Run]]:
    """Return the newest press at a moment, and the strip of its credit; `roomy`: many lines."""
    session = viewing.session
    strip, press = viewing.strip(moment.time_ns)
    if press is None or width <= 10:
        return [[("No press yet", DIM)]]
    times = session.times("press")
    place = int(np.searchsorted(times, press.time_ns, side="right"))
    several = bool(session.people) or press.person > 0
    by_whom = viewing.name_of(press.person) if several else ""
    lines = [press_line(press, len(times), place, session.start_ns, by_whom)]
    if strip is not None:
        lines += strip_lines(strip, viewing.rule.words, width, tall=roomy)
    return lines


def decision_lines(viewing: Viewing, moment: Moment, width: int, *, roomy: bool) -> list[list[Run]]:
    """Return what the agent thought at a moment, and beside or below it what a what-if did; `roomy`: many
    lines.
    """
    if moment.step < 0:
        lines: list[list[Run]] = [[("Between games", DIM)], [(viewing.own_words, DIM)]]
        if viewing.other is not None:
            lines += [[(f"What-if {viewing.other_name}", BOLD)], [(viewing.other_words, DIM)]]
        return lines
    size: Detail = "whole" if width >= (88 if viewing.other is not None else 44) else "compact"
    stacked = roomy and width < 88
    if viewing.other is not None and width < 70 and not stacked:
        size = "narrow"
    own, other = viewing.own_thought(moment.step), viewing.other_thought(moment.step)
    name = viewing.namer(moment.step)
    own_choice = None if own is None else own.chosen
    left = list(thought_lines(own, name, "Agent", detail=size))
    left.append([(viewing.own_words, DIM)])
    if viewing.other is None:
        return left
    title = viewing.other_name if size == "narrow" else f"What-if {viewing.other_name}"
    right = list(thought_lines(other, name, title, detail=size, others_choice=own_choice))
    right.append([(viewing.other_words, DIM)])
    return [*left, [], *right] if stacked else beside(left, right, width // 2)
