"""Figures of reaction-time fits: histogram with densities, Q-Q, and the paper's Fig. 4. Matplotlib loads on
use.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from core.feedback.credit import GammaDelay
from core.system.foreign_text import in_plot
from studies.reaction_time.families import GAMMA, SHIFTED_GAMMA, FamilyFit, distribution
from studies.reaction_time.goodness import q_q
from studies.reaction_time.sample import Sample

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000")
"""Distinguishable with any colour vision (Okabe & Ito)."""
LINES = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)))


def fit_figure(title: str, sample: Sample, fits: Sequence[FamilyFit]) -> Figure:
    """Draw histogram with the densities of the best family and both gammas, beside their Q-Q plot."""
    shown = _best_and_gammas(fits)
    figure = _figure(9.0, 3.8)
    left, right = figure.subplots(1, 2)
    _draw_densities(left, sample, shown)
    left.set_title(in_plot(title))
    low, high = sample.observed_s[0], sample.observed_s[-1]
    right.plot([low, high], [low, high], color="0.5", linewidth=1.0)
    for i, fit in enumerate(shown):
        fitted, seen = q_q(sample, fit)
        many = seen.size > 500  # thousands of points make a heavy SVG: draw them as pixels
        right.plot(fitted, seen, ".", markersize=3.0, color=COLORS[i], label=fit.family, rasterized=many)
    right.set_xlabel("fitted quantile (s)")
    right.set_ylabel("observed time (s)")
    right.set_title("Q-Q: points on the line fit")
    right.legend(frameon=False)
    return figure


def paper_figure_4(delays: Mapping[str, GammaDelay]) -> Figure:
    """Draw densities over the time before a reinforcement, the paper's gamma(2.5, 0.3) first (Fig. 4)."""
    figure = _figure(6.0, 3.8)
    axes = figure.subplots()
    everything = {"paper: gamma(2.5, 0.3)": GammaDelay(), **delays}
    time_s = np.linspace(0.0, 2.5, 1001)
    for i, (name, delay) in enumerate(everything.items()):
        p = {"shape": delay.shape, "scale_s": delay.scale_s, "offset_s": delay.offset_s}
        density = SHIFTED_GAMMA.freeze(SHIFTED_GAMMA.values(p)).pdf(time_s)
        axes.plot(time_s, density, color=COLORS[i % 5], linestyle=LINES[i % 5], label=name)
    axes.set_xlim(0.0, 2.5)
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel("time before reinforcement (s)")
    axes.set_ylabel("p(x), per second")
    axes.legend(frameon=False)
    return figure


def svg_text(figure: Figure) -> str:
    """Return a figure as SVG text without the file's preamble; equal figures give equal text."""
    import io

    import matplotlib

    with matplotlib.rc_context({"svg.hashsalt": "arl", "svg.fonttype": "none"}):
        buffer = io.StringIO()
        figure.savefig(buffer, format="svg", metadata={"Date": None})
    text = buffer.getvalue()
    return text[text.index("<svg") :]


def save(figure: Figure, folder: Path, name: str) -> tuple[Path, Path]:
    """Write a figure as PNG and SVG; return both paths."""
    png, svg = folder / f"{name}.png", folder / f"{name}.svg"
    figure.savefig(png, dpi=150)
    svg.write_text(svg_text(figure), encoding="utf-8")
    return png, svg


def _figure(width: float, height: float) -> Figure:
    from matplotlib.figure import Figure

    # Fixed margins: a layout engine takes longer than all the drawing.
    figure = Figure(figsize=(width, height))
    figure.subplots_adjust(
        left=0.6 / width, right=1.0 - 0.15 / width, bottom=0.55 / height, top=1.0 - 0.35 / height
    )
    return figure


def _best_and_gammas(fits: Sequence[FamilyFit]) -> list[FamilyFit]:
    best = min(fits, key=lambda fit: fit.aic)
    gammas = [fit for name in (GAMMA.name, SHIFTED_GAMMA.name) for fit in fits if fit.family == name]
    return [*gammas, *([best] if best not in gammas else [])]


def _draw_densities(axes: Axes, sample: Sample, fits: Sequence[FamilyFit]) -> None:
    x = sample.observed_s
    # Heights are fractions of all trials, so that time-outs leave the densities above the bars where they
    # belong.
    edges = np.histogram_bin_edges(x, bins="fd" if x.size >= 30 else 8)
    counts, edges = np.histogram(x, bins=edges)
    heights = counts / (sample.n * np.diff(edges))
    axes.stairs(heights, edges, fill=True, color="0.85", label=f"{x.size} responses")
    time_s = np.linspace(max(0.0, 2.0 * x[0] - x[-1], 0.5 * x[0]), x[-1] * 1.1, 400)
    for i, fit in enumerate(fits):
        frozen: Any = distribution(fit)
        axes.plot(time_s, frozen.pdf(time_s), color=COLORS[i], linestyle=LINES[i], label=fit.family)
    if sample.censored_s.size:
        axes.axvline(float(sample.censored_s[0]), color="0.3", linewidth=1.0)
        axes.annotate(f"{sample.censored_s.size} timed out", (float(sample.censored_s[0]), 0.0), rotation=90)
    axes.set_xlabel("reaction time (s)")
    axes.set_ylabel("density (per second)")
    axes.legend(frameon=False)
