"""What a report is made of: a Markdown page with figures, tables of intervals, and how it all came about."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np

from core.numerics.arrays import Floats
from core.numerics.streams import stream
from studies.comparison import Verdict, adjusted, paired_effect_size, probability_interval, sign_flip_p
from studies.experiments.results import Results
from studies.reaction_time.figures import COLORS, LINES, save
from studies.statistics import (
    Interval,
    few_trials_note,
    interquartile_mean_interval,
    mean_interval,
    median_interval,
    paired_difference,
    paired_ratio,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


MARKERS = "os^Dv<>P"
RESAMPLES = 10_000
"""Bootstrap samples behind every interval of a page."""


@dataclass(frozen=True, slots=True)
class Page:
    """A report, not yet written."""

    name: str
    text: str
    """Markdown; figures are linked as ../figures/NAME.png."""
    figures: dict[str, Figure] = field(default_factory=dict)
    """By file name without ending."""


QUICK = """\
**A quick run:** its trials were cut short, to see that everything works. Nothing on this page is a result; lengths of trials, and settings
below, are those of whole ones.
"""  # noqa: E501


def write_page(page: Page, into: Path, *, quick: bool = False, trials: int | None = None) -> list[Path]:
    """Write results/NAME.md and figures/*.png, *.svg below `into`; return the paths.

    Args:
        page: the report.
        into: folder.
        quick: the trials were quick ones: the page says so first.
        trials: how many there are per condition; where they are few, the page says first what that does to
            intervals.
    """
    (into / "results").mkdir(parents=True, exist_ok=True)
    (into / "figures").mkdir(parents=True, exist_ok=True)
    path = into / "results" / f"{page.name}.md"
    title, rest = page.text.split("\n", 1)
    few = None if trials is None else few_trials_note(trials)
    first = (QUICK if quick else "") + (f"\n**Few trials.** {few}\n" if few else "")
    path.write_text(f"{title}\n\n{first.lstrip()}{rest}" if first else page.text, encoding="utf-8")
    written = [path]
    for name, figure in page.figures.items():
        written.extend(save(figure, into / "figures", name))
    return written


def table(header: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """Return a Markdown table."""
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join("| " + " | ".join(str(cell) for cell in line) + " |" for line in lines) + "\n"


def number(value: float) -> str:
    """Return a number with three significant digits and without an exponent."""
    if not np.isfinite(value):
        return str(value)
    if abs(value) >= 100:
        return f"{value:.0f}"
    return f"{value:.3g}" if abs(value) >= 1e-3 or value == 0 else f"{value:.4f}"


def interval(found: Interval) -> str:
    """Return an estimate with its interval, as tables show it."""
    return f"{number(found.estimate)} [{number(found.low)}, {number(found.high)}]"


def p_value(p: float) -> str:
    """Return a p value as tables show it."""
    return "< 0.001" if p < 0.001 else f"{p:.3f}"


def summary_table(scores: Mapping[str, Floats], unit: str) -> str:
    """Return mean, interquartile mean and median of each condition's trials, with 95 % intervals.

    Args:
        scores: one number per trial, by the condition's label.
        unit: of the numbers.
    """
    rows = []
    for label, values in scores.items():
        rows.append(
            [
                label,
                len(values),
                interval(mean_interval(values, rng=_rng("mean", label), resamples=RESAMPLES)),
                interval(interquartile_mean_interval(values, rng=_rng("iqm", label), resamples=RESAMPLES)),
                interval(median_interval(values, rng=_rng("median", label), resamples=RESAMPLES)),
            ]
        )
    return table(["condition", "trials", f"mean, {unit}", "interquartile mean", "median"], rows)


def verdict(treated: str, control: str, scores: Mapping[str, Floats]) -> Verdict:
    """Compare two conditions over paired trials; scores > 0, by label."""
    first, second = scores[treated], scores[control]
    logs = np.log(first / second)
    p = sign_flip_p(logs, rng=_rng("flips", treated, control))
    return Verdict(
        treated,
        control,
        paired_ratio(first, second, rng=_rng("ratio", treated, control), resamples=RESAMPLES),
        paired_difference(first, second, rng=_rng("difference", treated, control), resamples=RESAMPLES),
        probability_interval(first, second, rng=_rng("improvement", treated, control)),
        paired_effect_size(logs) if len(logs) > 1 else float("nan"),
        p,
        p,
    )


def verdict_table(verdicts: Sequence[Verdict]) -> str:
    """Return comparisons, their p values corrected for all of them (Holm)."""
    rows = [
        [
            f"{found.treated} / {found.control}",
            interval(found.ratio),
            interval(found.difference),
            interval(found.improvement),
            number(found.effect_size),
            p_value(found.p),
            p_value(found.p_holm),
        ]
        for found in adjusted(verdicts)
    ]
    return table(["comparison", "ratio", "difference", "P(improvement)", "d_z (log)", "p", "p (Holm)"], rows)


HOW_TO_READ = """\
Trials pair by seed: the same pieces and the same first samples for every condition. Brackets hold 95 % bootstrap intervals
(percentile, 10,000 resamples). *Ratio*: geometric mean of treated / control over pairs; scores of games that end by chance are
close to exponential and spread in proportion, so ratios are the fair scale, and tests are on logarithms. *Difference*: of plain means.
*P(improvement)*: a random trial of one beats a random trial of the other. *p*: two-sided, 20,000 random sign flips; *Holm*: corrected
for all rows of the table.
"""  # noqa: E501


def claims_table(title: str, claims: Sequence[str], verdicts: Sequence[Verdict]) -> str:
    """Return claims in words, one verdict each, with whether they held."""
    rows = [
        (words, held(found), interval(found.ratio)) for words, found in zip(claims, verdicts, strict=True)
    ]
    return f"{in_short(rows)}\n{table([title, 'held', 'ratio'], rows)}"


def in_short(claims: Sequence[tuple[str, str, str]]) -> str:
    """Return a page's answer in three sentences.

    Args:
        claims: in words, whether each held (as `held` says it), and its ratio with the interval.
    """
    yes = [claim for claim in claims if claim[1] == "yes"]
    strongest = max(yes, key=lambda claim: float(claim[2].split()[0]), default=None)
    if strongest is None:
        second = "So none of them is shown."
    else:
        second = f"The largest effect: {strongest[0]}, by a ratio of {strongest[2]}."
    open_or_wrong = [f"{words} ({said}, {ratio})" for words, said, ratio in claims if said != "yes"]
    third = "No claim failed." if not open_or_wrong else f"What did not hold: {'; '.join(open_or_wrong)}."
    return f"**In short.** Of {len(claims)} claims {len(yes)} held. {second} {third}\n"


def held(found: Verdict) -> str:
    """Say whether a claim "treated is better than control" held: by its interval, and by its test (few
    trials).
    """
    if found.p >= 0.05:
        return "not shown"
    if found.ratio.low > 1.0:
        return "yes"
    return "no, the opposite" if found.ratio.high < 1.0 else "not shown"


def _flat(settings: dict[str, Any]) -> dict[str, Any]:
    """Return settings of a trial that wraps a protocol as those of the protocol and of what is around it."""
    around = dict(settings)
    return {**around.pop("protocol", {}), **around}


def how_it_was_made(results: Results, *, others: Sequence[Results] = ()) -> str:
    """Return seeds, versions, settings and departures: what is needed to do it again.

    Args:
        results: that the page is about.
        others: further results that went into it: their versions count, too.
    """
    record, seeds = results.record, results.seeds
    runs = [run for found in (results, *others) for run in found.record.software]
    versions = dict.fromkeys(", ".join(f"{name} {value}" for name, value in run.items()) for run in runs)
    departures = "\n".join(f"- {sentence}." for sentence in results.experiment.departures)
    settings = {name: _flat(record.conditions[name]) for name in results.conditions}
    common, own = shared_settings(settings)
    differing = "\n".join(
        f"- `{name}`: `{msgspec.json.encode(value).decode()}`" for name, value in own.items()
    )
    typed = results.experiment.typed
    quickly = " --quick" if record.quick else ""
    return f"""\
## How it was made

`arl experiment run {typed}{quickly} && arl experiment report {typed}{quickly or " --into docs"}`

- Trials: {len(seeds)} per condition, root seeds {seeds[0]} to {seeds[-1]}.
- Software: {"; ".join(versions)}.
{_unfinished(results)}
Departures from the paper, and what it leaves open:

{departures}

What differs between the conditions:

{differing}

<details><summary>Settings that all conditions share</summary>

```json
{msgspec.json.format(msgspec.json.encode(common)).decode()}
```

</details>
"""


def _unfinished(results: Results) -> str:
    """Return the line that names the conditions that are not reported; "" where all are."""
    missing = [
        f"{condition.name} ({results.left_out.get(condition.name, 0)})"
        for condition in results.experiment.conditions
        if condition.name not in results.trials
    ]
    if not missing:
        return ""
    return f"- Not reported, because too few of their trials were played: {', '.join(missing)}.\n"


def shared_settings(settings: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Split settings by condition into what all share and what is each one's own; nothing is left out.

    Args:
        settings: objects of plain JSON types by condition. Objects below them that have other keys than their
            likes (rules of another kind) are each one's own as a whole.
    """
    common: dict[str, Any] = {}
    own: dict[str, dict[str, Any]] = {name: {} for name in settings}
    for key in dict.fromkeys(key for value in settings.values() for key in value):
        there = {name: value[key] for name, value in settings.items() if key in value}
        values = list(there.values())
        everywhere = len(there) == len(settings)
        if everywhere and all(value == values[0] for value in values):
            common[key] = values[0]
        elif everywhere and all(isinstance(v, dict) and v.keys() == values[0].keys() for v in values):
            inner, rest = shared_settings(there)
            if inner:
                common[key] = inner
            for name, value in rest.items():
                own[name][key] = value
        else:
            for name, value in there.items():
                own[name][key] = value
    return common, own


def new_figure(width: float, height: float) -> Figure:
    """Return an empty figure that needs no display; sizes in inches."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def draw_curves(axes: Axes, x: Floats, curves: Mapping[str, Floats]) -> None:
    """Draw the mean over trials of each curve with its 95 % bootstrap band.

    Args:
        axes: where.
        x: shape (n,).
        curves: by label, shape (trials, n).
    """
    for place, (label, values) in enumerate(curves.items()):
        rng = _rng("curve", label)
        picks = rng.integers(0, len(values), size=(2000, len(values)))
        low, high = np.quantile(values[picks].mean(axis=1), [0.025, 0.975], axis=0)
        color = COLORS[place % len(COLORS)]
        axes.plot(
            x,
            values.mean(axis=0),
            color=color,
            linestyle=LINES[place % len(LINES)],
            marker=MARKERS[place % len(MARKERS)],
            markersize=3.5,
            markevery=max(1, len(x) // 15),
            label=label,
        )
        axes.fill_between(x, low, high, color=color, alpha=0.15, linewidth=0)
    axes.grid(alpha=0.3)


def _rng(*path: str) -> np.random.Generator:
    """Return the stream of one interval: the same page from the same files, always."""
    return stream(0, "report", *path)
