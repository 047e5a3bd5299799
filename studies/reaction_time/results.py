"""Makes the pages of results: real reaction times, fitted.

`python -m studies.reaction_time.results DATA DOCS` reads the folder of real data, writes
`results/reaction_time.md`, `results/reaction_time_pooling.md` and their figures below DOCS, and prints
nothing. Every number on the pages is from that run. It takes minutes of one core.
"""

import argparse
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from core.feedback.credit import GammaDelay
from core.numerics.arrays import Floats
from studies.reaction_time.exclusion import ExclusionPolicy, select
from studies.reaction_time.families import FAMILIES, GAMMA, SHIFTED_GAMMA, FamilyFit, fit_all
from studies.reaction_time.held_out import HeldOutScore, compare_held_out, markdown_table
from studies.reaction_time.read import Columns, read_rows
from studies.reaction_time.sample import Sample, sample

FITTED_TRIALS = (10, 20)
"""Trials of each person that are fitted where pooling is judged."""
ROOT_SEED = 1
N_SPLITS = 3
SMALL_LEAD = 2.0
"""A difference in AIC below this decides nothing."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DataSet:
    """One file of real times, and how it is read."""

    name: str
    source: str
    licence: str
    file: str
    columns: Columns


DATA_SETS = (
    DataSet(
        name="go reactions",
        source="OpenNeuro ds000030, stop-signal training, successful go reactions",
        licence="CC0",
        file="stop_signal_ds000030_events.tsv.gz",
        columns=Columns(rt="ReactionTime", unit="s", keep={"TrialOutcome": ("SuccessfulGo",)}),
    ),
    DataSet(
        name="flanker",
        source="OpenNeuro ds000102, flanker, correct reactions",
        licence="public domain",
        file="flanker_ds000102_events.tsv.gz",
        columns=Columns(rt="response_time", unit="s", keep={"correctness": ("correct",)}),
    ),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Fitted:
    """A data set's times and all families' fits."""

    data_set: DataSet
    samples: dict[str, Sample]
    together: Sample
    """All participants' times as one participant's."""
    fits_together: tuple[FamilyFit, ...]
    """Best AIC first, as in `fits`."""
    fits: dict[str, tuple[FamilyFit, ...]]

    @property
    def times_s(self) -> dict[str, Floats]:
        """Participant to times, in seconds, sorted."""
        return {name: one.observed_s for name, one in self.samples.items()}

    @property
    def title(self) -> str:
        """How the set is called in tables."""
        return f"{self.data_set.name}, {len(self.samples)} people"


def fit_data_set(data_set: DataSet, folder: Path) -> Fitted:
    """Read a data set with the usual exclusion policy, and fit each person and all together.

    Raises:
        ReadError: the file cannot be used.
        OSError: there is no such file.
    """
    rows = read_rows([folder / "reaction_time" / data_set.file], data_set.columns)
    samples, _ = select(rows, ExclusionPolicy())
    together = sample(np.concatenate([one.observed_s for one in samples.values()]))
    return Fitted(
        data_set=data_set,
        samples=samples,
        together=together,
        fits_together=fit_all(together),
        fits={name: fit_all(one) for name, one in samples.items()},
    )


def write_pages(sets: Sequence[Fitted], docs: Path) -> tuple[Path, ...]:
    """Write both pages and their figures below `docs`, over older ones; return what was written."""
    from studies.reaction_time.figures import fit_figure, paper_figure_4, save

    results, figures = docs / "results", docs / "figures"
    for folder in (results, figures):
        folder.mkdir(parents=True, exist_ok=True)
    last = sets[-1]
    title = f"{len(last.samples)} people, {last.data_set.name} (pooled)"
    delays = {f"{one.title}: shifted gamma": delay_of(one) for one in reversed(sets)}
    page, pooling = results / "reaction_time.md", results / "reaction_time_pooling.md"
    page.write_text(families_page(sets), encoding="utf-8")
    scores = {
        (n, one.title): compare_held_out(one.times_s, n_fitted=n, root_seed=ROOT_SEED, n_splits=N_SPLITS)
        for n in FITTED_TRIALS
        for one in reversed(sets)
    }
    pooling.write_text(pooling_page(scores), encoding="utf-8")
    return (
        page,
        pooling,
        *save(
            fit_figure(title, last.together, last.fits_together), figures, f"rt_{last.data_set.name}_pooled"
        ),
        *save(paper_figure_4(delays), figures, "rt_fig4_delay"),
    )


def delay_of(one: Fitted) -> GammaDelay:
    """Return the shifted gamma of all times together."""
    p = _fit_of(one, SHIFTED_GAMMA.name).parameters
    return GammaDelay(shape=p["shape"], scale_s=p["scale_s"], offset_s=p["offset_s"])


def families_page(sets: Sequence[Fitted]) -> str:
    """Return the page that compares families of densities, in Markdown."""
    read = "; ".join(
        f"{one.data_set.source}: {len(one.samples)} people, {one.together.n:,} trials "
        f"({one.data_set.licence})"
        for one in sets
    )
    policy = ExclusionPolicy()
    parts = [
        "# Real reaction times, fitted",
        _families_answer(sets),
        (
            f"Data: {read}.\nTimes below {policy.anticipation_below_s:g} s or above {policy.slow_above_s:g} "
            f"s are left out. "
            "Made by `python -m studies.reaction_time.results DATA docs`; the tests reproduce\nthe pooled "
            "ranking."
        ),
        "## AIC of pooled times",
        _aic_table(sets),
        "Shifted gamma: " + "; ".join(_parameter_words(one) for one in sets) + ".",
        "Among ex-Gaussian and the gammas alone the order is "
        + "; ".join(f"{', '.join(_ranking(one))} ({one.data_set.name})" for one in sets)
        + ".",
        "## Best family per person",
        _best_table(sets),
        "The best family beats the shifted gamma by less than 2 AIC in "
        + " and ".join(f"{_close(one)} of {len(one.samples)} ({one.data_set.name})" for one in sets)
        + " people.",
        f"![Pooled times: histogram, densities and Q-Q](../figures/rt_{sets[-1].data_set.name}_pooled.png)",
        "![Delay densities beside the paper's Fig. 4](../figures/rt_fig4_delay.png)",
        "See also `reaction_time_pooling.md` and `../trusting-a-fit.md`.",
    ]
    return "\n\n".join(parts) + "\n"


def pooling_page(scores: Mapping[tuple[int, str], tuple[HeldOutScore, ...]]) -> str:
    """Return the page that tells whether pooling helps, in Markdown.

    Args:
        scores: trials fitted and title of the data set to every method's score.
    """
    tables = [
        part
        for (n, title), some in scores.items()
        for part in (f"## {title}: {n} trials each", markdown_table(some).rstrip("\n"), _gain_words(some))
    ]
    parts = [
        "# Does pooling help? Real people, held-out trials",
        _pooling_answer(
            [one for some in scores.values() for one in some if one.method == "pooled, shifted gamma"]
        ),
        (
            "Of each person some trials, drawn at random, are fitted; the score is on all others. Means over "
            f"people and {N_SPLITS} random splits (root seed {ROOT_SEED}).\nPinball loss: mean over 19 "
            "quantiles, lower is better; gain: per person against a two-parameter gamma of one's own, with "
            "its standard error over\npeople. Made by `python -m studies.reaction_time.results DATA docs`."
        ),
        *tables,
        "## How to read this",
        (
            "A shifted gamma of one's own ends its offset just below the fastest of few responses, and so "
            "calls many a later response impossible (log density -inf): pooling the\noffset cures this. "
            "*Everybody alike* is one gamma for all. A gain is small beside the trial-to-trial noise, which "
            "no estimate removes; whether it is more than chance tells its\nstandard error."
        ),
    ]
    return "\n\n".join(parts) + "\n"


def _families_answer(sets: Sequence[Fitted]) -> str:
    """Return the answer of the page of families, in three sentences."""
    best = ", ".join(f"{one.fits_together[0].family} ({one.data_set.name})" for one in sets)
    places = [[fit.family for fit in one.fits_together].index(GAMMA.name) + 1 for one in sets]
    close = " and ".join(f"{_close(one)} of {len(one.samples)}" for one in sets)
    return (
        f"**In short.** Of nine families these fit pooled times best: {best}. The paper's two-parameter "
        f"gamma comes {' and '.join(f'{place}th' for place in places)}. Single people hardly differ so: in "
        f"{close} people no family beats the shifted gamma by 2 AIC."
    )


def _pooling_answer(pooled: Sequence[HeldOutScore]) -> str:
    """Return the answer of the page of pooling, in three sentences; scores of the pooled shifted gamma."""
    clear = [one for one in pooled if one.pinball_gain_ms > 2 * one.pinball_gain_se_ms]
    most = max(pooled, key=lambda one: one.pinball_gain_ms)
    return (
        f"**In short.** Pooling with others foretells held-out trials better in {len(clear)} of "
        f"{len(pooled)} comparisons by more than two standard errors. The gain is small: at most "
        f"{most.pinball_gain_ms:.2f} ms of {most.pinball_ms:.0f} ms. Without pooling a shifted gamma calls "
        "later trials of many people impossible; with it, of "
        f"{'nobody' if not any(one.impossible for one in pooled) else 'some'}."
    )


def _gain_words(scores: tuple[HeldOutScore, ...]) -> str:
    words = []
    for score in scores:
        if score.method.startswith("pooled"):
            ratio = score.pinball_gain_ms / score.pinball_gain_se_ms
            words.append(f"{score.method}: gain of {ratio:+.1f} standard errors")
    return "; ".join(words) + "."


def _fit_of(one: Fitted, family: str) -> FamilyFit:
    return next(fit for fit in one.fits_together if fit.family == family)


def _aic_table(sets: Sequence[Fitted]) -> str:
    aics = [{fit.family: fit.aic for fit in one.fits_together} for one in sets]
    rows = [
        [f"{name} (the paper's)" if name == GAMMA.name else name]
        + [f"**{aic[name]:,.1f}**" if aic[name] == min(aic.values()) else f"{aic[name]:,.1f}" for aic in aics]
        for name in sorted(FAMILIES, key=lambda name: aics[0][name])
    ]
    return _table(["family", *(one.title for one in sets)], rows)


def _best_table(sets: Sequence[Fitted]) -> str:
    best = [Counter(fits[0].family for fits in one.fits.values()) for one in sets]
    names = sorted(FAMILIES, key=lambda name: -best[0][name])
    rows = [[name, *(str(count[name]) for count in best)] for name in names]
    return _table(["best by AIC", *(one.title for one in sets)], rows)


def _parameter_words(one: Fitted) -> str:
    p = _fit_of(one, SHIFTED_GAMMA.name).parameters
    return (
        f"{one.data_set.name} shape {p['shape']:.2f}, scale {p['scale_s']:.3f} s, offset {p['offset_s']:.3f} "
        f"s"
    )


def _ranking(one: Fitted) -> list[str]:
    three = ("ex-Gaussian", GAMMA.name, SHIFTED_GAMMA.name)
    return [fit.family for fit in one.fits_together if fit.family in three]


def _close(one: Fitted) -> int:
    leads = [
        next(fit.aic for fit in fits if fit.family == SHIFTED_GAMMA.name) - fits[0].aic
        for fits in one.fits.values()
    ]
    return sum(lead < SMALL_LEAD for lead in leads)


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(cells) + " |" for cells in lines)


def main(arguments: Sequence[str] | None = None) -> None:
    """Make the pages; see the module."""
    parser = argparse.ArgumentParser(prog="python -m studies.reaction_time.results", description=__doc__)
    parser.add_argument(
        "data", type=Path, help="folder of real data: the one that ARL_DATA names for the tests"
    )
    parser.add_argument("docs", type=Path, help="folder of the documentation")
    given = parser.parse_args(arguments)
    try:
        sets = [fit_data_set(data_set, given.data) for data_set in DATA_SETS]
    except (OSError, ValueError) as error:
        parser.error(str(error))
    write_pages(sets, given.docs)


if __name__ == "__main__":
    main()
