"""`arl calibrate`: measure how long a participant takes to react and to judge."""

import os
import secrets
import shlex
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from arl_tui.command_line import say
from arl_tui.commands.play import in_language, need_terminal, read_protocol
from arl_tui.drawing_rate import FRAMES_PER_S
from arl_tui.language import later
from arl_tui.recordings import CALIBRATION_FOLDER

if TYPE_CHECKING:
    from arl_tui.calibration.app import CalibrationApp, CalibrationOutcome
    from arl_tui.calibration.fitting import Fitted
    from studies.reaction_time.protocol import TaskConfig

HINDRANCES = {
    "ssh": later("a network connection (SSH)"),
    "tmux": later("a terminal multiplexer (tmux)"),
    "screen": later("a terminal multiplexer (screen)"),
}


def run_calibration(
    participant: str,
    *,
    tasks: str,
    seed: int | None,
    trials: int | None,
    practice: int | None,
    recordings: Path,
    dry_run: bool,
    refit: bool = False,
    game: str = "tetris",
    protocol: Path | None = None,
    language: str | None = None,
) -> None:
    """Run the tasks in this terminal, print what they would be, or fit what has been measured."""
    from arl_tui.calibration.plan import CalibrationSetup, configure, new_parts, task_names

    sessions = read_protocol(protocol, game)
    try:
        configs = configure(
            task_names(tasks), n_trials=trials, n_practice=practice, game=sessions.game, protocol=sessions
        )
    except ValueError as error:
        raise click.BadParameter(str(error), param_hint="--tasks") from error
    if refit:
        fit_again(participant, configs, recordings)
        return
    setup = CalibrationSetup(
        participant=participant,
        configs=configs,
        root_seed=secrets.randbits(63) if seed is None else seed,
        recordings=recordings,
        hindrances=tuple(HINDRANCES[name] for name in hindrances()),
    )
    if dry_run:
        from studies.reaction_time.schedule import describe

        say("\n".join(describe(part.schedule) for part in new_parts(setup)), nl=False)
        return
    refuse_where_times_mean_nothing()
    need_terminal("arl calibrate", instead="arl calibrate --dry-run")
    os.environ.setdefault("TEXTUAL_FPS", FRAMES_PER_S)
    check_files(setup.recordings, participant)
    from arl_tui.calibration.app import CalibrationApp

    sessions = in_language(sessions, language, written=protocol is not None)
    _measure(CalibrationApp(replace(setup, language=sessions.screen.language)))


def _measure(app: "CalibrationApp") -> None:
    """Run the tasks in this terminal, and print what came of them."""
    outcome = app.run_in_terminal()
    if app.ended_by is not None:
        raise SystemExit(128 + app.ended_by)
    if outcome is None:
        raise click.ClickException("the app ended without a result; see the message above")
    tell(outcome)


def hindrances() -> list[str]:
    """Return what stands between keyboard and program: "ssh", "tmux", "screen"."""
    found = ["ssh"] if os.environ.get("SSH_CONNECTION") or os.environ.get("SSH_TTY") else []
    if os.environ.get("TMUX"):
        found.append("tmux")
    elif os.environ.get("STY"):
        found.append("screen")
    return found


def refuse_where_times_mean_nothing() -> None:
    """Stop with a message in a browser, and on systems whose key times are of another clock."""
    if os.environ.get("TEXTUAL_DRIVER"):
        raise click.ClickException(
            "a browser adds tens of milliseconds that differ from press to press: nothing can be measured in "
            "it. "
            "Run `arl calibrate` in a terminal on the participant's computer"
        )
    if sys.platform == "win32":
        raise click.ClickException(
            "key times are not comparable with frames' here; calibrate on Linux or macOS"
        )


def check_files(recordings: Path, participant: str) -> None:
    """Stop before anything is shown if the participant's earlier files cannot be read."""
    from arl_tui.participants import ParticipantError, read_delays
    from studies.reaction_time.trial_log import TrialFileError, read_trials

    try:
        for path in (recordings / CALIBRATION_FOLDER).glob(f"{participant}-*.jsonl"):
            read_trials(path)
        read_delays(recordings, participant)
    except (TrialFileError, ParticipantError) as error:
        raise click.ClickException(f"{error}. Move the file away, and run the command again.") from error


def tell(outcome: "CalibrationOutcome") -> None:
    """Print where everything is, and the results; leave with status 1 where something failed."""
    for path in outcome.files:
        say(f"Trials: {path}")
    tell_fit(outcome.fitted)
    if outcome.files and not outcome.finished and outcome.trouble is None:
        say("Not finished: run the same command within 12 hours to go on.")
    if outcome.trouble is not None:
        raise click.ClickException(outcome.trouble)


def fit_again(participant: str, configs: Sequence["TaskConfig"], recordings: Path) -> None:
    """Fit the newest finished session of each task, and keep the result."""
    from arl_tui.calibration.fitting import FitOrder, fit_files
    from arl_tui.calibration.plan import newest_complete
    from studies.reaction_time.trial_log import TrialFileError, read_trials

    check_files(recordings, participant)
    try:
        paths = [
            str(path)
            for config in configs
            for path in newest_complete(recordings, config.task, config.game)
            if read_trials(path).header.participant == participant
        ]
    except TrialFileError as error:
        raise click.ClickException(f"{error}. Move the file away, and run the command again.") from error
    if not paths:
        raise click.ClickException(
            f"{participant} has finished none of these tasks in {recordings / CALIBRATION_FOLDER}: "
            f"`arl calibrate --participant {shlex.quote(participant)}`"
        )
    order = FitOrder(recordings=str(recordings), participant=participant, files=tuple(paths))
    tell_fit(fit_files(order))


def tell_fit(fitted: "Fitted") -> None:
    """Print each task's delay, and why there is none."""
    for delay in fitted.delays:
        mean = delay.mean_s
        say(
            f"{delay.key}: mean {mean.estimate:.3f} s (95 %: {mean.low:.3f} to {mean.high:.3f} s), "
            f"{delay.n_observed} responses, {delay.family}"
        )
        for warning in delay.warnings:
            say(f"  beware: {warning}")
        if delay.pooled is not None:
            mean_s = delay.pooled.offset_s + delay.pooled.shape * delay.pooled.scale_s
            say(f"  pooled with {delay.pooled_people - 1} others: mean {mean_s:.3f} s")
    for task, reason in fitted.failures.items():
        say(f"{task}: no fit: {reason}")
    if fitted.kept_in:
        say(f"Delays: {fitted.kept_in}")
