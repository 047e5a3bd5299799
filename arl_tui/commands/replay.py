"""`arl replay`: the same session again, or what other rules would have made of it."""

import os
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from arl_tui.command_line import say
from arl_tui.commands.credit import credited_alike, what_if_delays
from arl_tui.commands.exact import (
    GETTING_READY,
    need_outputs,
    open_or_stop,
    protocol_of,
    read_or_stop,
    run_again,
)
from arl_tui.commands.play import read_protocol
from arl_tui.commands.what_if_table import table, write_csv
from arl_tui.games.registry import words_of
from core.feedback.delays import describe
from core.recording.reader import RecordingError
from core.session.effects import idle
from core.session.protocol import DEFAULTS, Protocol

if TYPE_CHECKING:
    from core.feedback.delays import Delay
    from studies.what_if import WhatIfRow

OFF_POLICY = (
    "Steps and presses are as recorded (off-policy): another agent would have shown, and been told, "
    "something else."
)


def _width() -> int | None:
    """Return how wide tables may be in columns: as the terminal; as wide as they need to be in a file."""
    return shutil.get_terminal_size().columns if sys.stdout.isatty() else None


def replay_recordings(paths: Sequence[Path], **options: Any) -> None:
    """Replay several recordings, one after the other; none hides another. Options as in `replay_recording`.

    Raises:
        click.ClickException: some recordings differ or cannot be used; each has been named with its reason.
    """
    if len(paths) == 1:
        replay_recording(paths[0], **options)
        return
    if options["csv_path"] or options["plot_path"]:
        raise click.UsageError(
            "--csv and --plot write the table of one recording: name one; or use `arl compare`"
        )
    failed: list[Path] = []
    for path in paths:
        say(f"\n{path}")
        try:
            replay_recording(path, **options)
        except click.UsageError:
            raise  # the options are wrong for all of them
        except click.ClickException as error:
            say(f"Error: {error.format_message()}", err=True)
            failed.append(path)
    if failed:
        names = ", ".join(str(path) for path in failed)
        raise click.ClickException(f"{len(failed)} of {len(paths)} recordings failed: {names}")


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
    if not credits and not schemes:
        again = open_or_stop(path, allow_truncated=allow_truncated)
        if csv_path or plot_path:
            raise click.UsageError("--csv and --plot write what --credit and --scheme compare: name a rule")
        say(GETTING_READY, err=True)
        run_again(again)
        return
    recording = read_or_stop(path, allow_truncated=allow_truncated)
    need_outputs(recording)
    chosen = protocol_of(recording) if protocol is None else read_protocol(protocol)
    if protocol is not None:
        for each in idle(chosen, DEFAULTS[chosen.game], ["what-if"]):
            say(f"Beware: {each}.", err=True)
    delays = what_if_delays(credits or [chosen.delay_of], recording, chosen)
    if credits and "rule" not in credits:
        chosen = credited_alike(chosen)
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
    _print_rows(rows, units, games)
    if csv_path is not None:
        write_csv(csv_path, rows, {describe(delay): source for delay, source in delays.items()}, units)
        say(f"Table: {csv_path}")
    if plot_path is not None:
        from arl_tui.commands.what_if_figure import draw

        draw(rows, plot_path, units)
        say(f"Figure: {plot_path}")


def _print_rows(rows: "Sequence[WhatIfRow]", units: str, games: int) -> None:
    """Print a what-if's table, and what has to be known of it; each row is a mean over `games` games."""
    say("\n".join(table(rows, units, _width())))
    say(OFF_POLICY)
    from studies.statistics import few_trials_note

    few = few_trials_note(games, "games")
    if few is not None:
        say(few)


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
    from core.combination.config import SCHEMES, check_learner
    from studies.what_if import WhatIfSettings, scheme_named, what_if

    own = next(name for name, kind in SCHEMES.items() if isinstance(protocol.agent.scheme, kind))
    names = list(schemes) or [own]
    for name in names:
        try:
            scheme = scheme_named(name, protocol.agent.scheme)
            check_learner(scheme, protocol.learner.kind, str(protocol.learner.__struct_config__.tag))
        except ValueError as error:
            raise click.BadParameter(str(error), param_hint="--scheme") from error
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
