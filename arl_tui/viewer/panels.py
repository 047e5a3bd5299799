"""Lines of text beside the game: the credit of a press, and what the agent thought. No widgets."""

from collections.abc import Callable, Iterator
from typing import Literal

from rich.style import Style

from arl_tui.viewer.rows import (
    BAD,
    BOLD,
    DIFFERS,
    DIM,
    GOOD,
    SHADES,
    TRUST,
    WEIGHT,
    Run,
    cells_to_runs,
    level,
)
from core.combination.episode_weights import FORM_NAMES
from core.system.foreign_text import printable
from studies.session_view.credit_strip import CreditStrip
from studies.session_view.session import Press
from studies.session_view.thoughts import Considered, Thought

ActionName = Callable[[int], str]
"""Names an action in at most 8 characters."""
Detail = Literal["whole", "compact", "narrow"]
"""How much room there is: any, 34 columns, or 17 columns for f(R, H) alone."""
COLUMNS: dict[Detail, tuple[int, ...]] = {"whole": (10, 9, 9), "compact": (8, 7, 7), "narrow": (7,)}
"""Widths of R, H and f(R, H)."""
SHOWN = 0.005
"""Shares below this are not written."""


def press_line(press: Press, n_presses: int, place: int, start_ns: int, by_whom: str = "") -> list[Run]:
    """Return which press it is: number among those that mean something, time, and what became of it.

    Args:
        press: which.
        n_presses: how many there are.
        place: its number, from 1.
        start_ns: when the recording begins.
        by_whom: who pressed, of several participants.
    """
    style = {"good": GOOD, "bad": BAD}.get(press.kind, DIM)
    seconds = (press.time_ns - start_ns) / 1e9
    by = "  simulated" if press.simulated else ""
    person = f"  {printable(by_whom, longest=20)}" if by_whom else ""
    person = "  a key of nobody" if press.person < 0 else person
    return [
        (f"Press {place} of {n_presses}  {seconds:.2f} s  ", None),
        (press.words, style),
        (f"  key {printable(press.key, longest=10)}{by}{person}", DIM),
    ]


def strip_lines(strip: CreditStrip, rule: str, width: int, *, tall: bool = True) -> list[list[Run]]:
    """Return the delay density laid back from the press, the steps on screen under it, and the share of each.

    Args:
        strip: what is drawn.
        rule: which rule it is, in words.
        width: columns.
        tall: the density takes two lines, not one.
    """
    merged = f"  part of press {strip.merged_into}'s burst" if strip.merged_into is not None else ""
    head: list[Run] = [("Credit ", None), (rule, BOLD), (merged, DIM)]
    n = width - 1
    density = strip.density(n)
    upper: list[Run] = [(level(float(max(0.0, height * 2 - 1))), TRUST) for height in density]
    lower: list[Run] = [(level(float(min(1.0, height * 2))), TRUST) for height in density]
    steps: list[tuple[str, Style | None]] = [(" ", None)] * n
    shares: list[tuple[str, Style | None]] = [(" ", None)] * n
    for place, stretch in enumerate(strip.stretches):
        begin = _column(stretch.begin_s, strip.span_s, n)
        end = _column(stretch.end_s, strip.span_s, n)
        if stretch.begin_s > strip.span_s and stretch.end_s >= strip.span_s:
            continue
        credited = stretch.share >= SHOWN
        style = SHADES[place % 2] + (BOLD if credited else DIM)
        for column in range(begin, max(end, begin + 1)):
            if column < n:
                steps[column] = (" ", style)
                shares[column] = (" ", style)
        _write(steps, begin, end, str(stretch.step), style)
        if credited:
            _write(shares, begin, end, f"{stretch.share:.0%}", style + GOOD)
    press: Run = ("◀", BOLD)
    lines = [head]
    if tall and density.any():
        lines += [cells_to_runs(upper), [*cells_to_runs(lower), press]]
    elif density.any():
        lines.append([*cells_to_runs([(level(float(height)), TRUST) for height in density]), press])
    lines += [[*cells_to_runs(steps), press], [*cells_to_runs(shares), (" ", None)]]
    return [*lines, [(_in_words(strip), None)]]


def _column(before_s: float, span_s: float, n: int) -> int:
    return min(max(round((1 - before_s / span_s) * n), 0), n)


def _write(cells: list[tuple[str, Style | None]], begin: int, end: int, text: str, style: Style) -> None:
    room = min(end, len(cells)) - begin
    if room < len(text):
        return
    start = begin + (room - len(text)) // 2
    for place, letter in enumerate(text, start):
        cells[place] = (letter, style)


def _in_words(strip: CreditStrip) -> str:
    parts = [
        f"step {step} {share:.0%}"
        for step, share in sorted(strip.shares.items(), key=lambda item: -item[1])
        if share >= SHOWN
    ][:4]
    if strip.outside >= SHOWN:
        parts.append(f"no step {strip.outside:.0%}")
    return "  ".join(parts) or "no step got credit"


def thought_lines(
    thought: Thought | None, name: ActionName, title: str, *, detail: Detail, others_choice: int | None = None
) -> Iterator[list[Run]]:
    """Yield what an agent thought at one decision.

    Args:
        thought: the decision; None while it is not known.
        name: of an action.
        title: whose thought it is.
        detail: how much is written.
        others_choice: what the agent beside it chose, where there is one.
    """
    if thought is None:
        yield [(title, BOLD), ("  not known yet", DIM)]
        return
    about: list[Run] = [
        ("  trust ", DIM),
        (f"{thought.trust:.2f}", TRUST),
        (" weight ", DIM),
        (f"{thought.weight:.2f}", WEIGHT),
        (" handed to H" if thought.handed_over else "", BOLD),
    ]
    policy = f"  policy {thought.policy}"
    if detail == "narrow":
        yield [(title[:26], BOLD)]
        yield [
            ("weight ", DIM),
            (f"{thought.weight:.2f}", WEIGHT),
            (" handed" if thought.handed_over else "", BOLD),
        ]
    elif detail == "compact":
        yield [(title[:34], BOLD), (policy if len(title) + len(policy) <= 34 else "", DIM)]
        yield about
    else:
        yield [(title, BOLD), (f"{policy}, {FORM_NAMES.get(thought.form, '')}", DIM), *about]
    columns = COLUMNS[detail]
    heads = ("R", "H", "f(R,H)")[-len(columns) :]
    yield [
        (
            "  " + " " * 8 + "".join(f"{head:>{width}}" for head, width in zip(heads, columns, strict=True)),
            DIM,
        )
    ]
    for place, action in enumerate(thought.best, 1):
        yield _action_line(place, action, thought, name, columns, others_choice)
    alone = "" if detail == "narrow" else " alone"
    yield [
        (f"R{alone} ", DIM), (name(thought.environment), None),
        (f"  H{alone} ", DIM), (name(thought.human) if thought.human >= 0 else "-", None),
    ]  # fmt: skip


def _action_line(
    place: int,
    action: Considered,
    thought: Thought,
    name: ActionName,
    columns: tuple[int, ...],
    others_choice: int | None,
) -> list[Run]:
    chosen = action.action == thought.chosen
    human = _number(action.h) if thought.human_known else "-"
    figures = (_number(action.r), human, _number(action.f))[-len(columns) :]
    text = "".join(f"{figure:>{width}}" for figure, width in zip(figures, columns, strict=True))
    differs = chosen and others_choice is not None and others_choice != action.action
    return [
        (f"{place} {name(action.action):<8}{text}", BOLD if chosen else None),
        (" ◀" if chosen else "", DIFFERS if differs else BOLD),
    ]


def _number(value: float) -> str:
    """Return a number in at most 7 characters."""
    if value == float("-inf"):
        return "out"
    text = f"{value:.3f}" if abs(value) < 100 else f"{value:.1f}"
    return text if len(text) <= 7 else f"{value:.2g}"


def beside(left: list[list[Run]], right: list[list[Run]], width: int) -> list[list[Run]]:
    """Return two blocks of lines side by side; the left one gets `width` columns, and is cut off there."""
    lines: list[list[Run]] = []
    for row in range(max(len(left), len(right))):
        first = _cut(left[row] if row < len(left) else [], width - 1)
        used = sum(len(text) for text, _ in first)
        lines.append([*first, (" " * (width - used), None), *(right[row] if row < len(right) else [])])
    return lines


def _cut(line: list[Run], width: int) -> list[Run]:
    kept: list[Run] = []
    for text, style in line:
        kept.append((text[: max(0, width)], style))
        width -= len(text)
    return kept


def key_line(keys: tuple[tuple[str, str], ...], width: int) -> list[Run]:
    """Return as many keys with their meanings as there is room for; the last two, help and quit, always."""
    *first, guide, leave = keys
    room = width - sum(len(key) + len(meaning) + 3 for key, meaning in (guide, leave))
    shown = []
    for key, meaning in first:
        room -= len(key) + len(meaning) + 3
        if room >= 0:
            shown.append((key, meaning))
    return [part for key, meaning in (*shown, guide, leave) for part in ((key, BOLD), (f" {meaning}  ", DIM))]
