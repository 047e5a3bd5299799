"""What a participant is told of themselves on the last page: games, presses, and how the agent played."""

from collections.abc import Iterator
from dataclasses import dataclass, field

from arl_tui.app.tally import beginning_and_end
from arl_tui.language import tr
from arl_tui.study import words


@dataclass(slots=True)
class Numbers:
    """What a participant did in this sitting, for the last page."""

    blocks: list[tuple[float, ...]] = field(default_factory=list)
    """Performance of each watched game, block by block."""
    presses: int = 0
    taken_back: int = 0
    unit: str = ""


def own_numbers(numbers: Numbers) -> Iterator[str]:
    """Yield what a participant did, and how the agent played, a remark each; no condition is named."""
    if not numbers.blocks:
        return
    counted = [tr(words.NUMBERS, games=sum(map(len, numbers.blocks)), presses=numbers.presses)]
    if numbers.taken_back:
        counted.append(tr(words.TAKEN_BACK, presses=numbers.taken_back))
    yield " ".join(counted)
    template = words.HOW_IT_PLAYED if len(numbers.blocks) == 1 else words.HOW_IT_PLAYED_IN_BLOCK
    lines = []
    for number, games in enumerate(numbers.blocks, start=1):
        first, last = beginning_and_end(games)
        unit = numbers.unit[:1].upper() + numbers.unit[1:] if len(numbers.blocks) == 1 else numbers.unit
        values = {"unit": unit, "first": f"{first:.3g}", "last": f"{last:.3g}"}
        if len(numbers.blocks) > 1:
            values["number"] = str(number)
        lines.append(tr(template, **values))
    yield "\n".join(lines)
