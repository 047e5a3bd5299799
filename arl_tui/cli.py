"""The command `arl`. Each command imports what it needs when it runs, so that `arl --help` answers at once."""

from pathlib import Path
from typing import Literal

import click

from arl_tui.command_line import Arl, ToWrite, recordings_option
from arl_tui.commands.experiment import experiment
from arl_tui.commands.fit import fit
from arl_tui.commands.import_log import ImportGroup
from arl_tui.commands.presses import presses
from arl_tui.commands.study import study
from arl_tui.commands.timing import timing
from arl_tui.commands.train import train
from arl_tui.commands.watch import watch

FILE = click.Path(exists=True, dir_okay=False, path_type=Path)
GAMES = click.Choice(["tetris", "keepaway"])
TETRIS = click.Choice(["tetris"])

seed_option = click.option(
    "--seed", type=click.IntRange(0, 2**63 - 1), help="Root seed; a new one by default."
)
protocol_option = click.option(
    "--protocol", type=FILE, help="TOML file with everything that is to be set; defaults without it."
)


def _pseudonym(_context: click.Context, _parameter: click.Parameter, value: str) -> str:
    if not value or len(value) > 32 or not all(letter.isalnum() or letter in "-_" for letter in value):
        raise click.BadParameter(
            f"{value!r}: a code of up to 32 letters, digits, '-' or '_', such as P01 - never a name"
        )
    return value


@click.group(cls=Arl, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(package_name="arl-tui", prog_name="arl")
def main() -> None:
    """Agents that learn from their environment and from a few unreliable key presses.

    Watch one play and tell it what you think of it (play), see how that goes without any effort (demo), and ask
    what other ways of learning would have made of the same session (replay).
    """


@main.command(short_help="Watch an agent learn a game and judge it by key presses.")
@click.argument("game", type=GAMES, default="tetris")
@protocol_option
@click.option(
    "--participant", callback=_pseudonym, default="P00", show_default=True, help="Code of the participant."
)
@seed_option
@click.option("--episodes", type=click.IntRange(1), help="How many games are watched.")
@click.option(
    "--credit",
    metavar="RULE",
    help="How presses are shared out among steps: the participant's own delay (participant, feedback-lag, simple, "
    "pooled; see `arl calibrate`), paper, or a rule as in `arl replay`. By default the protocol's choice (delay_of), the "
    "same for every participant; without a file that is a rule: previous in Tetris, gamma:2.5,0.3 in Keepaway.",
)
@click.option(
    "--resume",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    help="Go on with a session that broke off, after its last finished game. All settings are those of the file; the "
    "rest of the session is recorded beside it.",
)
@recordings_option(to_write=True)
@click.pass_context
def play(
    context: click.Context,
    game: str,
    protocol: Path | None,
    participant: str,
    seed: int | None,
    episodes: int | None,
    credit: str | None,
    resume: Path | None,
    recordings: Path,
) -> None:
    """Watch an agent learn GAME, and tell it by key presses what you think of it."""
    if resume is not None:
        from arl_tui.commands.resume import resume_session

        resume_session(context, resume)
        return
    from arl_tui.commands.play import play_session

    play_session(
        game,
        protocol=protocol,
        participant=participant,
        seed=seed,
        episodes=episodes,
        recordings=recordings,
        credit=credit,
    )


@main.command(short_help="See the whole path in a minute: watch, press, record, replay.")
@click.argument("game", type=GAMES, default="tetris")
@click.option(
    "--person",
    metavar="NAME",
    help="Who presses: expert (the default), lay, myopic, hesitant, noisy, useless, adversary, instructed, bursty, hasty, "
    "slow, tiring or leaves.",
)
@seed_option
@recordings_option(to_write=True)
def demo(game: str, person: str | None, seed: int | None, recordings: Path) -> None:
    """Show the whole path in about a minute: watch, press, record, replay, summary.

    A simulated participant presses keys; you may press, too. Without a terminal the same happens unseen.
    """
    from arl_tui.commands.demo import run_demo

    run_demo(game, somebody=person, seed=seed, recordings=recordings)


@main.command(short_help="Replay a recording exactly, or under other learning rules.")
@click.argument("recording", type=FILE)
@click.option(
    "--credit",
    "credits",
    multiple=True,
    metavar="RULE",
    help="What-if: how presses are shared out among steps: gamma:2.5,0.3 uniform:0.2,0.8 previous current, or participant (its own delay, see `arl calibrate`). May be given several times.",
)
@click.option(
    "--scheme",
    "schemes",
    multiple=True,
    metavar="NAME",
    help="What-if: how both rewards are combined, such as linear or annealed:episode (its weight falls per episode; else per "
    "watched-game). May be given several times.",
)
@click.option(
    "--games",
    type=click.IntRange(1),
    default=100,
    show_default=True,
    help="What-if: games that each resulting policy plays.",
)
@protocol_option
@seed_option
@click.option(
    "--workers",
    type=click.IntRange(1),
    help="Processes; one per core by default. The result does not depend on it.",
)
@click.option("--csv", "csv_path", type=ToWrite(), help="Write the table to a file.")
@click.option(
    "--plot",
    "plot_path",
    type=ToWrite(),
    help="Draw the table (PNG, SVG or PDF).",
)
@click.option(
    "--allow-truncated/--complete-only",
    default=True,
    show_default=True,
    help="Take a recording that was cut off for what it holds.",
)
def replay(
    recording: Path,
    credits: tuple[str, ...],
    schemes: tuple[str, ...],
    protocol: Path | None,
    games: int,
    seed: int | None,
    workers: int | None,
    csv_path: Path | None,
    plot_path: Path | None,
    allow_truncated: bool,
) -> None:
    """Run RECORDING again: exactly (status 1 and the first difference if it differs), or as a what-if."""
    from arl_tui.commands.replay import replay_recording

    replay_recording(
        recording,
        credits=credits,
        schemes=schemes,
        protocol=protocol,
        games=games,
        seed=seed,
        workers=workers,
        csv_path=csv_path,
        plot_path=plot_path,
        allow_truncated=allow_truncated,
    )


@main.group(name="import", cls=ImportGroup, short_help="Turn other programs' logs into recordings.")
def import_group() -> None:
    """Turn other programs' logs into recordings. Other packages may add importers: docs/importers.md."""


@import_group.command(name="tamer-log")
@click.argument("log", type=FILE)
@click.option(
    "--out",
    type=ToWrite(made=True),
    help="The recording; beside the log's name in the recordings folder by default.",
)
@recordings_option(to_write=True)
def import_tamer_log(log: Path, out: Path | None, recordings: Path) -> None:
    """Import LOG, a log of TAMER's Tetris (Knox)."""
    from arl_tui.commands.import_log import import_log

    import_log(log, out=out or recordings / "imported" / f"{log.stem}.jsonl")


@import_group.command(name="evaluations")
@click.argument("table", type=FILE)
@click.option(
    "--column",
    multiple=True,
    metavar="WHAT=NAME",
    help="Which column holds what: participant=NAME (participant_id), time=NAME (time_s), value=NAME (value), "
    "delay=NAME (delay_s, if there is one).",
)
@click.option(
    "--by", multiple=True, metavar="COLUMN", help="Make a recording of each value (a task, a session)."
)
@click.option(
    "--unit",
    type=click.Choice(["s", "ms", "us", "ns"]),
    help="Unit of the times, unless their columns' names end in one. Never guessed.",
)
@click.option("--encoding", metavar="NAME", help="Code page of the table, as in `arl fit`.")
@click.option(
    "--out",
    type=ToWrite(folder=True),
    help="Folder for the recordings; in the recordings folder by default.",
)
@recordings_option(to_write=True)
def import_evaluations(
    table: Path,
    column: tuple[str, ...],
    by: tuple[str, ...],
    unit: str | None,
    encoding: str | None,
    out: Path | None,
    recordings: Path,
) -> None:
    """Import TABLE, evaluations of an agent: who pressed when, what value, how long after the event judged.

    The recordings give delays (`arl fit`), bursts and reports (`arl presses`); without states they cannot be replayed.
    """
    from arl_tui.commands.import_log import import_with, pairs

    settings = pairs(column, "--column")
    for name, value in (("by", ",".join(by)), ("unit", unit), ("encoding", encoding)):
        if value:
            settings[name] = value
    import_with("evaluations", table, out or recordings / "imported" / table.stem, settings)


@main.command(short_help="Measure how long a participant takes to react and to judge.")
@click.option("--participant", callback=_pseudonym, required=True, help="Code of the participant.")
@click.option(
    "--tasks",
    default="simple,choice,feedback-lag",
    show_default=True,
    metavar="LIST",
    help="Which: simple, choice, go-no-go, memory-search, visual-search, recognition, feedback-lag.",
)
@click.option("--trials", type=click.IntRange(1), help="Scored trials per task; 40 by default.")
@click.option("--practice", type=click.IntRange(0), help="Practice trials per task; 8 by default.")
@seed_option
@recordings_option(to_write=True)
@click.option("--dry-run", is_flag=True, help="Print every trial as it would be run, and stop.")
@click.option(
    "--game",
    type=click.Choice(["tetris", "keepaway"]),
    default="tetris",
    show_default=True,
    help="Which game is watched and judged in feedback-lag.",
)
@click.option(
    "--protocol",
    type=FILE,
    help="TOML file of the sessions to come: feedback-lag shows its game at its pace.",
)
@click.option(
    "--refit",
    is_flag=True,
    help="Measure nothing: fit the newest finished trials again, pooled with everybody there is by now.",
)
def calibrate(
    participant: str,
    tasks: str,
    trials: int | None,
    practice: int | None,
    seed: int | None,
    recordings: Path,
    dry_run: bool,
    game: Literal["tetris", "keepaway"],
    protocol: Path | None,
    refit: bool,
) -> None:
    """Measure how long a participant takes to react, and to judge what the agent does.

    The delay of judging (feedback-lag) is the one by which `arl play --credit participant` assigns credit.
    """
    from arl_tui.commands.calibrate import calibrate as run

    run(
        participant,
        tasks=tasks,
        seed=seed,
        trials=trials,
        practice=practice,
        recordings=recordings,
        dry_run=dry_run,
        refit=refit,
        game=game,
        protocol=protocol,
    )


@main.command(short_help="Play Tetris yourself with the agent's own four moves.")
@click.argument("game", type=TETRIS, default="tetris")
@seed_option
def practice(game: str, seed: int | None) -> None:
    """Play GAME yourself, with the agent's own four moves."""
    from arl_tui.commands.practice import practise

    practise(game, seed=seed)


@main.command(name="protocol", short_help="Print a complete protocol of a game: a file to start from.")
@click.argument("game", type=GAMES, required=False)
@protocol_option
@click.option("--check", type=FILE, help="Say what this protocol file will do, and what has no effect in it.")
@click.option("--markdown", is_flag=True, help="Print docs/protocol.md: every setting of every type.")
def show_protocol(game: str | None, protocol: Path | None, check: Path | None, markdown: bool) -> None:
    """Print a complete protocol of GAME (tetris by default) in TOML: a file to start from.

    Every key is there with its meaning, its range and unit or its choices, and the sessions in which it has an effect.
    """
    if sum((check is not None, markdown, protocol is not None)) > 1:
        raise click.UsageError("use one of --protocol, --check and --markdown")
    if markdown:
        from arl_tui.commands.protocol_page import print_page

        print_page()
    elif check is not None:
        from arl_tui.commands.check_protocol import check_protocol
        from arl_tui.commands.play import read_protocol

        check_protocol(check, read_protocol(check, game))
    else:
        from arl_tui.commands.protocol import print_protocol

        print_protocol(game, protocol)


@main.command(name="recordings", short_help="List the recordings there are, and check each.")
@recordings_option(to_write=False)
@click.option("--csv", "csv_path", type=ToWrite(), help="Write the list to a file, with everything it says.")
@click.option(
    "--publish",
    type=ToWrite(folder=True),
    metavar="DIR",
    help="Copy all sound recordings into a new folder, without dates in headers and names, chained anew.",
)
def list_recordings(recordings: Path, csv_path: Path | None, publish: Path | None) -> None:
    """List the recordings there are, with what each holds and how its session ended, and check each.

    Status 1 where a file is damaged: each of them is named with its reason, and hides no other.
    """
    from arl_tui.commands.recordings import list_all, publish_all

    if publish is not None:
        publish_all(recordings, publish)
        return
    list_all(recordings, csv_path=csv_path)


main.add_command(experiment)
main.add_command(fit)
main.add_command(study)
main.add_command(presses)
main.add_command(timing)
main.add_command(train)
main.add_command(watch)


if __name__ == "__main__":
    main()
