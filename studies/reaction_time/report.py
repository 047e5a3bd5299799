"""The result of a reaction-time study as files: JSON for machines, one self-contained page for people,
figures.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path

import msgspec

from core.feedback.credit import GammaDelay
from core.numerics.clock import wall_time_utc
from core.system.foreign_text import in_html as escape
from studies.reaction_time.exclusion import Row, Selection
from studies.reaction_time.figures import fit_figure, paper_figure_4, save, svg_text
from studies.reaction_time.fit import DelayEstimate, GroupFit, ParticipantFit
from studies.reaction_time.read import write_rows
from studies.reaction_time.sample import Sample

MOST_FIGURES = 12
"""Participants with a figure of their own on the page; all have one as PNG and SVG."""
NOT_AN_EVALUATION = (
    "A simple reaction (about 0.3 s) is not an evaluation: judging what an agent did takes 0.5 to 0.75 s and "
    "more. "
    "For credit assignment use the feedback-lag task, or know that these delays are shorter than feedback's."
)
_STYLE = """
body{font:16px/1.45 system-ui,sans-serif;max-width:64rem;margin:2rem auto;padding:0 1rem;color:#222}
table{border-collapse:collapse;font-size:.9rem}td,th{padding:.2rem .6rem;text-align:right;border-bottom:1px solid #ddd}
td:first-child,th:first-child{text-align:left}.warn{background:#fff3d6;padding:.6rem 1rem}
figure{margin:1rem 0}svg{max-width:100%;height:auto}.wide{overflow-x:auto}
"""  # noqa: E501


class Result(msgspec.Struct, frozen=True, kw_only=True):
    """Everything a study found, and how: the content of `result.json`."""

    format: str = "arl-reaction-time-result"
    version: int = 1
    created_utc: str
    task: str
    """What was measured, e.g. "simple" or "feedback lag"; "unknown" for files that do not say."""
    files: tuple[str, ...]
    selection: Selection
    """Exclusion policy, verdict of every row, counts."""
    group: GroupFit


def write_report(
    folder: Path,
    *,
    task: str,
    files: Sequence[str],
    rows: Sequence[Row],
    samples: Mapping[str, Sample],
    selection: Selection,
    group: GroupFit,
) -> Result:
    """Write result.json, rows.tsv, report.html and all figures into a new folder; return what result.json
    holds.

    Raises:
        FileExistsError: where the folder exists; reports are never overwritten.
    """
    folder.mkdir(parents=True)
    result = Result(
        created_utc=wall_time_utc(), task=task, files=tuple(files), selection=selection, group=group
    )
    (folder / "result.json").write_bytes(msgspec.json.format(msgspec.json.encode(result), indent=1))
    write_rows(folder / "rows.tsv", rows, selection.verdicts)
    (folder / "report.html").write_text(html_report(result, samples), encoding="utf-8")
    figures = folder / "figures"
    figures.mkdir()
    for i, (name, one) in enumerate(group.participants.items(), start=1):
        save(fit_figure(name, samples[name], one.fits), figures, f"fit_{i:03d}_{_file_name(name)}")
    save(paper_figure_4(_delays(group)), figures, "fig4_delay")
    return result


def read_result(path: Path) -> Result:
    """Read `result.json` again, e.g. to take a participant's delay for a session."""
    try:
        return msgspec.json.decode(path.read_bytes(), type=Result)
    except msgspec.MsgspecError as error:
        raise ValueError(f"{path}: not a result of the reaction-time study: {error}") from error


def html_report(result: Result, samples: Mapping[str, Sample]) -> str:
    """Return the one-page report: no script, nothing loaded from elsewhere."""
    group = result.group
    shown = list(group.participants.values())[:MOST_FIGURES]
    figures = [
        f"<figure>{svg_text(fit_figure(p.participant, samples[p.participant], p.fits))}</figure>"
        for p in shown
    ]
    left_out = len(group.participants) - len(shown)
    parts = [
        f"<h1>Reaction times: {escape(result.task)}</h1>",
        f"<p>{len(group.participants)} participants fitted, {escape(result.created_utc)}.</p>",
        f"<p>Files: {escape(', '.join(result.files))}.</p>",
        "" if result.task == "feedback lag" else f'<p class="warn">{NOT_AN_EVALUATION}</p>',
        "<h2>Delays</h2>",
        (
            "<p>Estimate and profile-likelihood interval. Where the shape is not identified, trust mean and "
            "quantiles.</p>"
        ),
        _delay_table(group),
        *_pooled_part(group),
        "<h2>Which density fits</h2>",
        _family_table(group),
        "<h2>The paper's Fig. 4</h2>",
        f"<figure>{svg_text(paper_figure_4(_delays(group)))}</figure>",
        "<h2>Fits</h2>",
        *figures,
        f"<p>{left_out} more participants have their figures in the folder.</p>" if left_out else "",
        "<h2>What was left out</h2>",
        _exclusion_table(result),
    ]
    body = "\n".join(part for part in parts if part)
    return (
        '<!doctype html><html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width,initial-scale=1">'
        f"<title>Reaction times</title><style>{_STYLE}</style></head><body>{body}</body></html>\n"
    )


def text_table(group: GroupFit) -> str:
    """Return the delays as a table of plain text, one participant and gamma family per line."""
    lines = [
        f"{'participant':<16}{'density':<15}{'n':>5}{'mean s':>8}{'95 % interval':>16}{'5-95 % s':>14}  shape"
    ]
    for one in group.participants.values():
        for delay in (one.gamma, one.shifted_gamma):
            e, interval = delay.estimates, delay.profile["mean_s"]
            shape = f"{delay.shape:.1f}" if delay.shape_identified else f"{delay.shape:.1f} not identified"
            sure, range_s = f"{interval.low:.3f} {interval.high:.3f}", f"{e['q05_s']:.2f} {e['q95_s']:.2f}"
            lines.append(
                f"{one.participant:<16}{delay.family:<15}{delay.n_observed:>5}{e['mean_s']:>8.3f}"
                f"{sure:>16}{range_s:>14}  {shape}"
            )
    lines += [f"{name:<16}not fitted: {reason}" for name, reason in group.failures.items()]
    return "\n".join(lines) + "\n"


def _delays(group: GroupFit) -> dict[str, GammaDelay]:
    """Return the first participants' shifted delays, as many as the figure has line styles left."""
    some = list(group.participants.values())[:4]
    return {f"{one.participant}, shifted gamma": one.shifted_gamma.gamma_delay() for one in some}


def _delay_table(group: GroupFit) -> str:
    head = (
        "participant",
        "density",
        "responses",
        "mean (s)",
        "sd (s)",
        "5 % (s)",
        "50 % (s)",
        "95 % (s)",
        "shape",
        "p",
    )
    rows = []
    for one in group.participants.values():
        for delay in (one.gamma, one.shifted_gamma):
            cells = [_with_interval(delay, name) for name in ("mean_s", "sd_s", "q05_s", "q50_s", "q95_s")]
            shape = _with_interval(delay, "shape") + ("" if delay.shape_identified else " not identified")
            p = "" if delay.goodness is None else f"{delay.goodness.p_value:.3f}"
            rows.append((one.participant, delay.family, str(delay.n_observed), *cells, shape, p))
    return _table(head, rows)


def _pooled_part(group: GroupFit) -> list[str]:
    if not group.pooled:
        return []
    rows = [
        (
            name,
            f"{d.shape * d.scale_s:.3f}",
            f"{d.shape:.1f}",
            f"{d.scale_s:.4f}",
            f"{100 * d.own_share:.0f} %",
        )
        for name, d in group.pooled.items()
    ]
    head = ("participant", "mean (s)", "shape", "scale (s)", "mean from own data")
    return [
        "<h2>Pooled over participants</h2>",
        "<p>Gamma, offset 0: for few trials per person.</p>",
        _table(head, rows),
    ]


def _with_interval(delay: DelayEstimate, name: str) -> str:
    interval = delay.profile[name]
    digits = ".1f" if name == "shape" else ".3f"
    return f"{delay.estimates[name]:{digits}} ({interval.low:{digits}} to {interval.high:{digits}})"


def _family_table(group: GroupFit) -> str:
    rows = [
        (one.participant, one.fits[0].family, _lead(one, "gamma"), _lead(one, "shifted gamma"), one.verdict)
        for one in group.participants.values()
    ]
    return _table(("participant", "best by AIC", "gamma: AIC above", "shifted: AIC above", "in words"), rows)


def _lead(one: ParticipantFit, family: str) -> str:
    return f"{next(fit.aic for fit in one.fits if fit.family == family) - one.fits[0].aic:.1f}"


def _exclusion_table(result: Result) -> str:
    verdicts = sorted({verdict for counts in result.selection.counts.values() for verdict in counts})
    rows = [
        (name, *(str(counts.get(verdict, 0)) for verdict in verdicts))
        for name, counts in result.selection.counts.items()
    ]
    policy = ", ".join(f"{k} = {v}" for k, v in msgspec.structs.asdict(result.selection.policy).items())
    reasons = {**result.selection.unusable, **result.group.failures}
    notes = "".join(f"<p>{escape(name)}: not fitted. {escape(why)}</p>" for name, why in reasons.items())
    return (
        f"<p>Policy: {escape(policy)}. Every row and its verdict: "
        f"rows.tsv.</p>{_table(('participant', *verdicts), rows)}{notes}"
    )


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    top = "".join(f"<th>{escape(cell)}</th>" for cell in head)
    body = "".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    return f'<div class="wide"><table><tr>{top}</tr>{body}</table></div>'


def _file_name(participant: str) -> str:
    """Return the participant with everything but letters, digits, - and _ replaced."""
    return "".join(sign if sign.isalnum() or sign in "-_" else "_" for sign in participant)
