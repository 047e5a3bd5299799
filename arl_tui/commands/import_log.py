"""`arl import tamer-log`: other people's logs as recordings."""

from pathlib import Path

import click


def import_log(log: Path, *, out: Path) -> None:
    """Import a TAMER log and say what it held."""
    from core.recording.importers.tamer_log import TamerLogError, import_tamer_log

    try:
        report = import_tamer_log(log, out)
    except (TamerLogError, OSError) as error:
        raise click.ClickException(str(error)) from error
    click.echo(f"Recording: {out}")
    click.echo(
        f"  {report.episodes} episodes, {report.placements} placements, {report.presses} presses\n"
        f"  dropped: {report.duplicate_presses} presses that were listed twice\n"
        f"  sorted: {report.out_of_order} presses that stood behind a later one\n"
        f"  longest step: {report.longest_step_s:.1f} s (a pause of the session is kept as a long step)"
    )
