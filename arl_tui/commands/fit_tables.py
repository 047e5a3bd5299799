"""What `arl fit` prints: one participant in full, or many with a line each."""

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from arl_tui.commands.fit_request import FAULTS
from arl_tui.commands.text_plot import beside, histogram, histogram_edges, scatter

if TYPE_CHECKING:
    from studies.reaction_time.exclusion import Row, Selection
    from studies.reaction_time.families import FamilyFit
    from studies.reaction_time.fit import DelayEstimate, GroupFit, ParticipantFit
    from studies.reaction_time.intervals import Interval
    from studies.reaction_time.sample import Sample

QUANTITIES = {
    "shape": "shape",
    "scale_s": "scale (s)",
    "offset_s": "offset (s)",
    "mean_s": "mean (s)",
    "mode_s": "mode (s)",
    "sd_s": "sd (s)",
    "q05_s": "5 % (s)",
    "q50_s": "50 % (s)",
    "q95_s": "95 % (s)",
}


def reading_lines(rows: "Sequence[Row]", selection: "Selection") -> Iterator[str]:
    """Yield how many rows were read, kept and left out, and why."""
    counts = Counter(selection.verdicts)
    used = [f"{counts[name]} {name}" for name in ("kept", "timed out") if counts[name]]
    left_out = [f"{n} {name}" for name, n in sorted(counts.items()) if name not in ("kept", "timed out")]
    yield f"Rows: {len(rows)} read; {', '.join(used) or 'none usable'}" + (
        f"; left out: {', '.join(left_out)}." if left_out else "; none left out."
    )
    p = selection.policy
    yield (
        f"Policy: faster than {p.anticipation_below_s:g} s is no reaction, slower than {p.slow_above_s:g} s "
        f"something else, above {p.absurd_above_s:g} s a fault of the file; time-outs: {p.time_outs}."
    )


def fault_lines(rows: "Sequence[Row]", selection: "Selection") -> Iterator[str]:
    """Yield a warning for each kind of fault, with the place of the first one."""
    for fault in FAULTS:
        found = [row for row, verdict in zip(rows, selection.verdicts, strict=True) if verdict == fault]
        if found:
            yield (
                f"Warning: {len(found)} {fault} {'time' if len(found) == 1 else 'times'}, the first at "
                f"{found[0].source} ({found[0].rt_s:g} s). Left out; find out where it comes from."
            )


def not_fitted_lines(selection: "Selection", group: "GroupFit", only: Sequence[str]) -> Iterator[str]:
    """Yield who was not fitted, and why; with names in `only`, nobody else."""
    reasons = {**selection.unusable, **group.failures}
    for name, reason in reasons.items():
        if not only or name in only:
            yield f"Not fitted: {name}: {reason}"


def participant_lines(one: "ParticipantFit", sample: "Sample") -> Iterator[str]:
    """Yield everything about one participant."""
    late = f", {sample.censored_s.size} timed out" if sample.censored_s.size else ""
    yield f"{one.participant}: {sample.observed_s.size} responses{late}"
    yield ""
    yield from family_lines(one.fits)
    yield ""
    yield from delay_lines(one)
    yield ""
    yield one.verdict
    for delay in (one.gamma, one.shifted_gamma):
        warning = "" if delay.shape_identified else "Warning: "
        yield f"{warning}{delay.family}: {delay.reason}"
    yield ""
    yield from plot_lines(one, sample)


def family_lines(fits: "Iterable[FamilyFit]") -> Iterator[str]:
    """Yield the table of families, best AIC first."""
    fits = list(fits)
    yield f"{'family':<19}{'log-lik':>9}{'AIC':>10}{'BIC':>10}{'AIC above':>11}  parameters"
    for fit in fits:
        parameters = "  ".join(f"{name} {value:.4g}" for name, value in fit.parameters.items())
        edge = f"  ({', '.join(fit.at_bound)} at the edge of what is allowed)" if fit.at_bound else ""
        yield (
            f"{fit.family:<19}{fit.log_likelihood:>9.2f}{fit.aic:>10.2f}{fit.bic:>10.2f}"
            f"{fit.aic - fits[0].aic:>11.2f}  {parameters}{edge}"
        )


def delay_lines(one: "ParticipantFit") -> Iterator[str]:
    """Yield both gammas: parameters and what they mean, with intervals, and goodness of fit."""
    pair = (one.gamma, one.shifted_gamma)
    level = 100 * one.gamma.profile["mean_s"].level
    yield f"{'':<12}{'gamma (offset 0)':<31}shifted gamma"
    for name, title in QUANTITIES.items():
        cells = [_with_interval(delay, name) for delay in pair]
        yield f"{title:<12}{cells[0]:<31}{cells[1]}".rstrip()
    tests = [_goodness(delay) for delay in pair]
    yield f"{'goodness':<12}{tests[0]:<31}{tests[1]}"
    yield (
        f"Intervals: {level:g} % by profile likelihood (mode: bootstrap). * ends at the edge of what is "
        f"allowed."
    )


def _with_interval(delay: "DelayEstimate", name: str) -> str:
    digits = 2 if name == "shape" else 4
    text = f"{delay.estimates[name]:.{digits}f}"
    if name == "offset_s" and delay.family == "gamma":
        return f"{text} (set)"
    interval = delay.profile.get(name) or delay.bootstrap.get(name)
    return text if interval is None else f"{text} {_ends(interval, digits)}"


def _ends(interval: "Interval", digits: int) -> str:
    low = f"{interval.low:.{digits}f}" + "*" * interval.low_is_bound
    high = f"{interval.high:.{digits}f}" + "*" * interval.high_is_bound
    return f"[{low}, {high}]"


def _goodness(delay: "DelayEstimate") -> str:
    if delay.goodness is None:
        return "not defined (time-outs)" if delay.n_censored else "not tested"
    return f"p = {delay.goodness.p_value:.3f} (Anderson-Darling)"


def plot_lines(one: "ParticipantFit", sample: "Sample") -> Iterator[str]:
    """Yield the histogram with the gammas' and the best family's densities, and both gammas' Q-Q plots."""
    # Half a second that only this needs.
    from studies.reaction_time.families import distribution
    from studies.reaction_time.goodness import q_q

    by_name = {fit.family: fit for fit in one.fits}
    gammas = [by_name["gamma"], by_name["shifted gamma"]]
    shown = gammas if one.fits[0] in gammas else [*gammas, one.fits[0]]
    edges = histogram_edges(sample.observed_s)
    width_s = np.diff(edges)
    # Shares of all trials, so that time-outs leave the densities above the bars where they belong.
    heights = np.histogram(sample.observed_s, bins=edges)[0] / (sample.n * width_s)
    densities = {fit.family: np.diff(distribution(fit).cdf(edges)) / width_s for fit in shown}
    yield from histogram(edges, heights, densities)
    yield ""
    blocks = [
        [
            f" Q-Q, {fit.family}: points on the dots fit",
            *scatter(*q_q(sample, fit)),
            " fitted s, upwards observed s",
        ]
        for fit in gammas
    ]
    yield from beside(blocks[0], blocks[1])


def group_lines(group: "GroupFit") -> Iterator[str]:
    """Yield one line per participant and gamma, then what holds of them together."""
    from studies.reaction_time.report import text_table

    yield from text_table(group).splitlines()
    people = list(group.participants.values())
    best = Counter(one.fits[0].family for one in people)
    yield ""
    yield "Best by AIC: " + ", ".join(f"{name} {n}" for name, n in best.most_common()) + "."
    for name in ("gamma", "shifted gamma"):
        leads = [next(fit.aic for fit in one.fits if fit.family == name) - one.fits[0].aic for one in people]
        clearly = sum(lead >= 10.0 for lead in leads)
        yield (
            f"Another family fits clearly better than the {name} (AIC lower by 10 or more) in {clearly} of "
            f"{len(people)}."
        )
    for name in ("gamma", "shifted_gamma"):
        unsure = sum(not getattr(one, name).shape_identified for one in people)
        if unsure:
            yield (
                f"Warning: the shape of the {name.replace('_', ' ')} is not identified in {unsure} of "
                f"{len(people)}: "
                "trust mean and quantiles there."
            )


def pooled_lines(group: "GroupFit") -> Iterator[str]:
    """Yield the delays pooled over participants."""
    yield f"{'pooled':<16}{'mean s':>8}{'shape':>8}{'scale s':>9}  own data's fraction of the mean"
    for name, delay in group.pooled.items():
        mean = delay.offset_s + delay.shape * delay.scale_s
        yield f"{name:<16}{mean:>8.3f}{delay.shape:>8.2f}{delay.scale_s:>9.4f}  {delay.own_share:.0%}"
