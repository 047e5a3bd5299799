"""The figure of `arl fit`: one participant's fit, or the mean delays of many."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from core.system.foreign_text import in_plot

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from studies.reaction_time.fit import GroupFit
    from studies.reaction_time.sample import Sample


def draw_fit(group: "GroupFit", samples: "Mapping[str, Sample]", path: Path) -> None:
    """Write the figure; the suffix says the format.

    Raises:
        ValueError: matplotlib does not know the suffix.
    """
    from studies.reaction_time.figures import fit_figure

    people = list(group.participants.values())
    if len(people) == 1:
        (one,) = people
        figure = fit_figure(one.participant, samples[one.participant], one.fits)
    else:
        figure = means_figure(group)
    figure.savefig(path, dpi=150)


def means_figure(group: "GroupFit") -> "Figure":
    """Draw each participant's mean delay with its interval, and the middle 90 % of the times, sorted by
    mean.
    """
    # Half a second that only this needs; Figure, not pyplot: no window system is asked for.
    from matplotlib.figure import Figure

    people = sorted(group.participants.values(), key=lambda one: one.shifted_gamma.estimates["mean_s"])
    rows = range(len(people))
    named = len(people) <= 60
    figure = Figure(figsize=(7.0, 1.2 + 0.2 * min(len(people), 60)), layout="constrained")
    axes = figure.add_subplot()
    delays = [one.shifted_gamma for one in people]
    mean = [delay.estimates["mean_s"] for delay in delays]
    axes.hlines(
        rows,
        [delay.estimates["q05_s"] for delay in delays],
        [delay.estimates["q95_s"] for delay in delays],
        color="0.8",
        label="5 % to 95 % of the times",
    )
    error = [
        [delay.estimates["mean_s"] - delay.profile["mean_s"].low for delay in delays],
        [delay.profile["mean_s"].high - delay.estimates["mean_s"] for delay in delays],
    ]
    level = 100 * delays[0].profile["mean_s"].level
    axes.errorbar(
        mean,
        rows,
        xerr=error,
        fmt="o",
        markersize=3.0 if named else 1.5,
        color="#0072b2",
        label=f"mean with {level:g} % interval",
    )
    if group.pooled:
        pooled = [group.pooled[one.participant] for one in people]
        means = [each.offset_s + each.shape * each.scale_s for each in pooled]
        axes.plot(means, rows, "x", color="#d55e00", label="pooled mean")
    axes.set_yticks(
        list(rows) if named else [], [in_plot(one.participant) for one in people] if named else []
    )
    axes.set_xlim(left=0.0)
    axes.set_xlabel("reaction time (s), shifted gamma")
    axes.set_ylabel(f"{len(people)} participants")
    axes.legend(loc="lower right")
    return figure
