"""The command `arl`: the list of its commands. Each is imported when it is used, so that `arl --help` answers
at once.
"""

import click

from arl_tui.command_line import Arl, Listed
from arl_tui.standard_streams import why_not_drawable

COMMANDS = (
    Listed(
        "anonymise",
        "anonymise:anonymise",
        "Copy recordings without dates, terminal facts, free text and codes.",
    ),
    Listed(
        "archive",
        "archive:archive",
        "Make a folder ready for OSF or Zenodo: anonymised data, tables, codebook.",
    ),
    Listed(
        "calibrate",
        "calibrate_command:calibrate",
        "Measure how long a participant takes to react and to judge.",
    ),
    Listed("compare", "compare:compare", "Compare sessions: participants, conditions or protocols."),
    Listed("demo", "demo_command:demo", "See the whole path in a minute: watch, press, record, replay."),
    Listed("doctor", "doctor:doctor", "Check this machine and terminal: go or no go."),
    Listed("experiment", "experiment:experiment", "Run the experiments behind the figures, and report them."),
    Listed("export", "export:export", "Write data as tables, BIDS or Minari."),
    Listed("fit", "fit:fit", "Fit delay densities to reaction times in files."),
    Listed("import", "import_log:import_group", "Turn other programs' logs into recordings."),
    Listed("play", "play_command:play", "Watch an agent learn a game and judge it by key presses."),
    Listed(
        "practice",
        "practice_command:practice",
        "Play Tetris or Keepaway yourself, with the agent's own moves.",
    ),
    Listed("presses", "presses:presses", "Report values, delays and bursts of recorded presses."),
    Listed(
        "protocol",
        "show_protocol:show_protocol",
        "Print a complete protocol of a game: a file to start from.",
    ),
    Listed(
        "recordings", "recordings_command:list_recordings", "List the recordings there are, and check each."
    ),
    Listed("replay", "replay_command:replay", "Replay recordings exactly, or under other learning rules."),
    Listed("study", "study:study", "Run a whole study from one file."),
    Listed("timing", "timing:timing", "Test how exactly this machine measures reaction times."),
    Listed("train", "train:train", "Let keepers learn by Sarsa, unseen, and keep the policy."),
    Listed("warm-up", "warm_up_command:warm_up_command", "Compile now what the first games would compile."),
    Listed("watch", "watch:watch", "See a recorded session again, or look at a policy of Keepaway."),
)


class ArlWithHome(Arl):
    """The command `arl`: without a command it opens the home page, where there is a terminal."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Read the arguments; see `click.Group.parse_args`."""
        if not args and not ctx.resilient_parsing and not why_not_drawable():
            from arl_tui.commands.start import run_home

            run_home()
            ctx.exit()
        return super().parse_args(ctx, args)


@click.group(
    cls=ArlWithHome,
    listed=COMMANDS,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
)
@click.version_option(package_name="arl-tui", prog_name="arl")
def main() -> None:
    """Agents that learn from their environment and from a few unreliable key presses.

    Watch one play and tell it what you think of it (play), see how that goes without any effort (demo), and
    ask what other ways of learning would have made of the same session (replay).
    """


if __name__ == "__main__":
    main()
