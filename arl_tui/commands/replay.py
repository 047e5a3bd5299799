"""`arl replay`: the same session again, or what other rules would have made of it."""

import csv
import os
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from arl_tui.commands.credit import what_if_delays
from arl_tui.commands.exact import GETTING_READY, protocol_of, read_or_stop, run_again
from arl_tui.commands.play import read_protocol
from arl_tui.words import words_of
from core.effects import idle
from core.feedback.delays import describe
from core.protocol import DEFAULTS, Protocol
from core.recording.reader import RecordingError

if TYPE_CHECKING:
    from core.feedback.delays import Delay
    from studies.what_if import WhatIfRow

OFF_POLICY = "Steps and presses are as recorded (off-policy): another agent would have shown, and been told, something else."
W_H_SHOWN = 6
"""Values of w_h in the table: evenly spaced over the episodes, the last one among them."""


def replay_recording(
    path: Path,
    *,
    credits: Sequence[str],
    schemes: Sequence[str],
    protocol: Path | None,
    games: int,
    seed: int | None,
    workers: int | None,
    csv_path: Path | None,
    plot_path: Path | None,
    allow_truncated: bool,
) -> None:
    """Replay exactly, or compare rules if any are named."""
    recording = read_or_stop(path, allow_truncated=allow_truncated)
    if not credits and not schemes:
        if csv_path or plot_path:
            raise click.UsageError("--csv and --plot write what --credit and --scheme compare: name a rule")
        click.echo(GETTING_READY, err=True)
        run_again(recording)
        return
    chosen = protocol_of(recording) if protocol is None else read_protocol(protocol)
    if protocol is not None:
        for each in idle(chosen, DEFAULTS[chosen.game], ["what-if"]):
            click.echo(f"Beware: {each}.", err=True)
    delays = what_if_delays(credits or [chosen.delay_of], recording, chosen)
    rows = compare(
        recording.path,
        chosen,
        delays=list(delays),
        schemes=schemes,
        games=games,
        seed=seed or 0,
        workers=workers,
    )
    units = words_of(chosen.game).units[1]
    click.echo("\n".join(table(rows, units)))
    click.echo(OFF_POLICY)
    if csv_path is not None:
        write_csv(csv_path, rows, {describe(delay): source for delay, source in delays.items()}, units)
        click.echo(f"Table: {csv_path}")
    if plot_path is not None:
        from arl_tui.commands.what_if_figure import draw

        draw(rows, plot_path, units)
        click.echo(f"Figure: {plot_path}")


def compare(
    path: Path,
    protocol: Protocol,
    *,
    delays: "Sequence[Delay]",
    schemes: Sequence[str],
    games: int,
    seed: int,
    workers: int | None,
) -> "list[WhatIfRow]":
    """Work out the table, with a bar that shows how far it is."""
    from core.combination.config import SCHEMES
    from studies.what_if import WhatIfSettings, what_if

    own = next(name for name, kind in SCHEMES.items() if isinstance(protocol.agent.scheme, kind))
    names = list(schemes) or [own]
    unknown = [name for name in names if name not in SCHEMES]
    if unknown:
        raise click.BadParameter(f"{unknown[0]!r}: use one of {', '.join(SCHEMES)}", param_hint="--scheme")
    with click.progressbar(length=len(delays) * len(names), label="Learning again", file=sys.stderr) as bar:
        try:
            return what_if(
                path,
                protocol,
                delays,
                names,
                WhatIfSettings(games=games, root_seed=seed),
                workers=workers or os.cpu_count() or 1,
                on_progress=lambda: bar.update(1),
            )
        except RecordingError as error:
            raise click.ClickException(str(error)) from error


def table(rows: "Iterable[WhatIfRow]", units: str = "lines") -> Iterable[str]:
    """Yield the lines of the table; `units` is what is counted per game."""
    rows = list(rows)
    scores = [
        f"{row.lines.estimate:.1f} [{row.lines.low:.1f}, {row.lines.high:.1f}]"
        + (f" {row.capped:.0%} cut" if row.capped else "")
        for row in rows
    ]
    head = f"{units} per game"
    wide = max(len(text) for text in (head, *scores))
    yield f"{'credit':24} {'scheme':18} {head:>{wide}} {'log-loss (rate)':>16} {'on steps':>8}  w_h over episodes"
    for row, score in zip(rows, scores, strict=True):
        loss = f"{row.log_loss:.3f} ({row.log_loss_of_the_rate:.3f})"
        trend = " ".join(f"{value:.2f}" for value in _evenly(row.w_h))
        yield f"{row.credit:24} {row.scheme:18} {score:>{wide}} {loss:>16} {row.credited:>8.0%}  {trend}"


def _evenly(values: Sequence[float]) -> list[float]:
    if len(values) <= W_H_SHOWN:
        return list(values)
    last = len(values) - 1
    return [values[round(last * k / (W_H_SHOWN - 1))] for k in range(W_H_SHOWN)]


def write_csv(
    path: Path, rows: "Iterable[WhatIfRow]", sources: Mapping[str, str], units: str = "lines"
) -> None:
    """Write the table with every figure in full precision; w_h as one field, values separated by spaces.

    Args:
        path: of the new file.
        rows: of the table.
        sources: where each credit rule comes from, in words, by the rule.
        units: what is counted per game.
    """
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(
            [
                "credit",
                "scheme",
                units,
                f"{units}_low",
                f"{units}_high",
                "level",
                "capped",
                "log_loss",
                "log_loss_of_the_rate",
                "credited",
                "w_h",
                "credit_source",
            ]
        )
        for row in rows:
            interval = row.lines
            writer.writerow(
                [
                    row.credit,
                    row.scheme,
                    interval.estimate,
                    interval.low,
                    interval.high,
                    interval.level,
                    row.capped,
                    row.log_loss,
                    row.log_loss_of_the_rate,
                    row.credited,
                    " ".join(map(repr, row.w_h)),
                    sources[row.credit],
                ]
            )
