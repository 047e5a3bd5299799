"""A comparison as figures (PNG, SVG) and as one HTML page that needs nothing else."""

import base64
import html
import io
import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

from core.system.foreign_text import printable
from core.system.whole_file import write_whole
from studies.session_view.comparison import (
    MEASURES,
    By,
    Difference,
    SessionFigures,
    group_interval,
    over_games,
)
from studies.statistics import few_trials_note

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Groups = dict[str, list[SessionFigures]]
PANELS: Final = (
    ("performances", "performance per game"),
    ("presses", "presses per game"),
    ("trust", "trust after the game"),
    ("weight", "weight in use"),
)
_STYLE: Final = """
body { font: 15px/1.45 system-ui, sans-serif; color: #1c2430; margin: 2em auto; max-width: 72em; padding: 0 1em; }
table { border-collapse: collapse; margin: 0.6em 0 1.6em; }
th, td { padding: 0.25em 0.7em; border-bottom: 1px solid #d5dae2; text-align: right; }
th:first-child, td:first-child, td.word, th.word { text-align: left; }
img { max-width: 100%; } .note { color: #5a6575; }
"""  # noqa: E501


def draw_comparison(groups: Groups) -> "Figure":
    """Return a figure: performance, presses, trust and weight over games, a line for each group."""
    # Half a second that only this needs; Figure, not pyplot: no window system is asked for.
    from matplotlib.figure import Figure
    from matplotlib.ticker import MaxNLocator

    figure = Figure(figsize=(10.0, 6.4), layout="constrained")
    for axes, (what, heading) in zip(figure.subplots(2, 2).flat, PANELS, strict=True):
        for number, (name, sessions) in enumerate(groups.items()):
            colour = f"C{number % 10}"
            for session in sessions:
                row = over_games([session], what)
                axes.plot(range(1, len(row) + 1), row, color=colour, alpha=0.25, linewidth=0.8)
            mean = over_games(sessions, what)
            mark = "osD^vP*X"[number % 8]
            # A dollar sign would be read as mathematics.
            label = f"{printable(name, longest=40)} (n = {len(sessions)})".replace("$", r"\$")
            axes.plot(range(1, len(mean) + 1), mean, color=colour, marker=mark, markersize=4, label=label)
        axes.set_title(heading, fontsize="medium")
        axes.set_xlabel("game")
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        axes.grid(alpha=0.3)
    handles, labels = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=3, fontsize="small")
    return figure


def write_page(path: Path, groups: Groups, differences: Sequence[Difference], by: By) -> None:
    """Write one HTML page: groups, differences, sessions, and the figure. Every text from a file is escaped.

    Raises:
        OSError: it cannot be written.
    """
    drawn = io.BytesIO()
    draw_comparison(groups).savefig(drawn, format="svg")
    picture = base64.b64encode(drawn.getvalue()).decode()
    n = min(len(sessions) for sessions in groups.values())
    few = few_trials_note(n, "sessions per group")
    simulated = origins_note(session for sessions in groups.values() for session in sessions)
    parts = [
        "<!DOCTYPE html>",
        '<html lang="en"><head><meta charset="utf-8"><title>Sessions compared</title>',
        f"<style>{_STYLE}</style></head><body>",
        f"<h1>Sessions compared, by {by}</h1>",
        f'<p><img alt="Performance, presses, trust and weight over games" src="data:image/svg+xml;base64,{picture}"></p>',  # noqa: E501
        f"<p><b>{_text(simulated)}</b></p>" if simulated else "",
        "<h2>Groups</h2>",
        _table(*group_table(groups)),
        f'<p class="note">{_text(few)}</p>' if few else "",
        "<h2>Differences</h2>",
        _table(*difference_table(differences)) if differences else "<p>There is one group only.</p>",
        "<h2>Sessions</h2>",
        _table(*session_table([session for sessions in groups.values() for session in sessions]), words=5),
        f'<p class="note">{"<br>".join(map(_text, EXPLAINED))}</p>',
        "</body></html>",
    ]
    write_whole(path, "\n".join(parts) + "\n")


EXPLAINED: Final = (
    "Intervals are 95 % percentile bootstrap intervals of means.",
    (
        "agreement: share of the presses' credit that praises the environment policy's own choice, or blames "
        "another."
    ),
    "match: fraction of steps at which the environment's and the human policy would have done the same.",
    "consistency: standard errors by which a model foresaw the presses better than chance (2: not random).",
    "delay: median time from a step's appearance to the press; own delay: mean measured by arl calibrate.",
)


def origins_note(sessions: Iterable[SessionFigures]) -> str:
    """Return a sentence on simulated sessions; "" where there are none."""
    origins = [session.origin for session in sessions]
    simulated = origins.count("simulated")
    if not simulated:
        return ""
    mixed = " People and simulated participants are compared." if simulated < len(origins) else ""
    return f"SIMULATED: in {simulated} of {len(origins)} sessions a simulated participant pressed.{mixed}"


def group_table(groups: Groups) -> tuple[list[str], list[list[str]]]:
    """Return head and rows: a row per measure, a column per group."""
    head = ["measure", *(f"{printable(name, longest=40)} (n = {len(some)})" for name, some in groups.items())]
    rows = []
    for measure, heading in MEASURES.items():
        found = [group_interval(sessions, measure) for sessions in groups.values()]
        if any(interval is not None for interval in found):
            rows.append([heading, *("-" if interval is None else str(interval) for interval in found)])
    return head, rows


def difference_table(differences: Iterable[Difference]) -> tuple[list[str], list[list[str]]]:
    """Return head and rows of the paired differences."""
    rows = [
        [
            f"{printable(found.group, longest=40)} minus {printable(found.control, longest=40)}",
            MEASURES[found.measure],
            "-" if found.interval is None else str(found.interval),
            f"{found.pairs} by {found.paired_by}",
        ]
        for found in differences
    ]
    return ["groups", "measure", "difference", "pairs"], rows


def session_table(sessions: Iterable[SessionFigures]) -> tuple[list[str], list[list[str]]]:
    """Return head and rows: a row per session."""
    head = [
        "file", "participant", "origin", "condition", "protocol", "games", "per game", "good", "bad", "taken back", "refused",  # noqa: E501
        "agreement", "consistency", "delay s", "own delay s", "trust", "weight",
    ]  # fmt: skip
    rows = [
        [
            *(
                printable(text, longest=40)
                for text in (one.file, one.participant, one.origin, one.condition, one.protocol)
            ),
            str(len(one.performances)),
            number(one.value("performance")),
            f"{one.good.sum():.0f}",
            f"{one.bad.sum():.0f}",
            str(one.taken_back),
            str(one.refused),
            number(one.agreement),
            number(one.consistency),
            number(one.delay_s),
            number(one.own_delay_s),
            number(float(one.trust[-1]) if len(one.trust) else float("nan")),
            number(float(one.weight[-1]) if len(one.weight) else float("nan")),
        ]
        for one in sessions
    ]
    return head, rows


def number(value: float) -> str:
    """Return a figure in three digits; `-` where it is not known."""
    return "-" if math.isnan(value) else f"{value:.3g}"


def _table(head: Sequence[str], rows: Sequence[Sequence[str]], words: int = 1) -> str:
    lines = ["<table><tr>", *(f"<th>{_text(cell)}</th>" for cell in head), "</tr>"]
    for row in rows:
        cells = (
            f"<td{' class=word' if place < words else ''}>{_text(cell)}</td>"
            for place, cell in enumerate(row)
        )
        lines += ["<tr>", *cells, "</tr>"]
    return "".join([*lines, "</table>"])


def _text(text: str) -> str:
    return html.escape(printable(text, longest=None))
