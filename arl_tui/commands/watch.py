"""`arl watch`: see a recorded session again (`watch_recording`), or look at any policy of Keepaway."""

import atexit
import os
import re
import secrets
import sys
import threading
from pathlib import Path
from typing import TYPE_CHECKING

import click
from click.core import ParameterSource

from arl_tui.command_line import NumberRange, ToWrite, say, theme_option

if TYPE_CHECKING:
    from arl_tui.app.compile_order import Order
    from arl_tui.screens.watch import WatchApp
    from core.keepaway.pitch import KeepawayConfig
    from core.keepaway.policy_file import SavedPolicy
    from core.keepaway.viewed_match import ViewedMatch

BENCHMARKS = {"hand": "hand-coded", "random": "random", "hold": "always hold"}
VISIONS = ("exact", "360", "90")
LONGEST_S = 1e7
"""Seconds of a recording that can be asked for: four months."""
FASTEST = 20.0
"""Simulated seconds per second of a policy."""
FOR_POLICIES = ("policy", "seed", "episodes", "keepers", "takers", "size", "vision", "detail")
"""Options of `arl watch keepaway` that a recording has no use for."""
DETAIL_NAMES = ("ascii", "half", "braille")
"""Written out here so that `--help` need not load them; a test compares."""


def parse_region(
    _context: click.Context, _parameter: click.Parameter, text: str | None
) -> tuple[float, float] | None:
    """Return both numbers of a region such as 20x20 or 30x20: metres from left to right and down."""
    if text is None:
        return None
    found = re.fullmatch(r"(\d+(?:\.\d+)?)x(\d+(?:\.\d+)?)", text.lower().replace(" ", ""))
    if found is None:
        raise click.BadParameter(f"{text!r}: two numbers of metres such as 20x20 or 30x20")
    return float(found[1]), float(found[2])


region_option = click.option(
    "--size",
    metavar="LxW",
    callback=parse_region,
    help="Region in metres, from left to right and down; 20x20 by default.",
)
keepers_option = click.option("--keepers", type=click.IntRange(2, 9), help="3 by default.")
takers_option = click.option("--takers", type=click.IntRange(1, 9), help="2 by default.")
vision_option = click.option(
    "--vision",
    type=click.Choice(VISIONS),
    help="What players see: everything exactly, all round as the server tells it (default), or 90 degrees.",
)


class GameOrRecording(click.ParamType):  # type: ignore[type-arg]
    """The name of a game whose policies can be watched, or a recording."""

    name = "keepaway|FILE"

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> "str | Path":
        """Return the game's name, or the path of a file that exists."""
        if value == "keepaway" or isinstance(value, Path):
            return Path(value) if isinstance(value, Path) else "keepaway"
        path = Path(str(value))
        if not path.exists():
            self.fail(
                f"{str(value)!r} is neither keepaway nor a file: name a recording (`arl recordings`)",
                param,
                ctx,
            )
        return path


@click.command(short_help="See a recorded session again, or look at a policy of Keepaway.")
@click.argument("game", type=GameOrRecording(), default="keepaway", metavar="[keepaway|FILE]")
@click.option(
    "--policy",
    default="hand",
    show_default=True,
    metavar="hand|random|hold|FILE",
    help="Who plays: a benchmark policy, what `arl train keepaway` has saved (.npz), or what the keepers had "
    "learned by the end of a recorded session (.jsonl).",
)
@click.option("--seed", type=click.IntRange(0, 2**63 - 1), help="Root seed; a new one by default.")
@click.option("--episodes", type=click.IntRange(1), help="Leave after so many.")
@click.option(
    "--speed",
    type=NumberRange(0.02, 64.0),
    default=1.0,
    show_default=True,
    help="Simulated seconds per second, at most 20; 0.25 is slow motion. FILE: recorded seconds per second "
    "of a film.",
)
@keepers_option
@takers_option
@region_option
@vision_option
@click.option("--detail", type=click.Choice(DETAIL_NAMES), help="Rendering; the finest this terminal shows.")
@click.option(
    "--credit", metavar="RULE", help="FILE: a what-if beside it under this credit rule, as in `arl replay`."
)
@click.option(
    "--scheme", metavar="NAME", help="FILE: a what-if beside it under this scheme, as in `arl replay`."
)
@click.option("--at", type=NumberRange(0.0, LONGEST_S), metavar="SECONDS", help="FILE: where to begin.")
@click.option("--until", type=NumberRange(0.0, LONGEST_S), metavar="SECONDS", help="FILE: where a film ends.")
@click.option(
    "--export",
    type=ToWrite(),
    metavar="FILM",
    help="FILE: write a film instead: .gif, .mp4 (needs ffmpeg) or .cast (asciinema).",
)
@theme_option
@click.pass_context
def watch(
    context: click.Context,
    game: "str | Path",
    policy: str,
    seed: int | None,
    episodes: int | None,
    speed: float,
    keepers: int | None,
    takers: int | None,
    size: tuple[float, float] | None,
    vision: str | None,
    detail: str | None,
    credit: str | None,
    scheme: str | None,
    at: float | None,
    until: float | None,
    export: Path | None,
) -> None:
    """See FILE, a recorded session, again: on a timeline, with credit, values and what-ifs
    (docs/look-at-a-session.md).

    Or look at a policy playing Keepaway (--policy), as fast or slowly as you like; nothing is recorded then.
    """
    if isinstance(game, Path):
        _refuse(context, FOR_POLICIES, "for `arl watch keepaway` only; a recording holds what was played")
        from arl_tui.commands.watch_recording import watch_recording

        os.environ.setdefault("TEXTUAL_FPS", "30")
        watch_recording(game, credit=credit, scheme=scheme, export=export, at=at, until=until, speed=speed)
        return
    if speed > FASTEST:
        raise click.BadParameter(f"{speed:g} is above {FASTEST:g}", param_hint="--speed")
    _refuse(
        context, ("credit", "scheme", "at", "until", "export"), "for a recording only: `arl watch FILE.jsonl`"
    )
    from arl_tui.commands.play import need_terminal
    from arl_tui.drawing_rate import FRAMES_PER_S

    need_terminal("arl watch", instead="arl train keepaway --help")
    os.environ.setdefault("TEXTUAL_FPS", FRAMES_PER_S)
    saved = None if policy in BENCHMARKS else read_policy(Path(policy))
    config = task(saved, keepers=keepers, takers=takers, size=size, vision=vision)
    _watch_policy(
        policy,
        saved,
        config,
        secrets.randbits(63) if seed is None else seed,
        speed=speed,
        episodes=episodes,
        detail=detail,
    )


def _watch_policy(
    policy: str,
    saved: "SavedPolicy | None",
    config: "KeepawayConfig",
    root_seed: int,
    *,
    speed: float,
    episodes: int | None,
    detail: str | None,
) -> None:
    """Look at a policy: a benchmark by its name, or a saved one."""
    from arl_tui.app.compile_order import match_order
    from arl_tui.screens.watch import WatchApp, WatchScreen
    from arl_tui.widgets.pitch_ink import DETAILS

    def prepare() -> "ViewedMatch":
        get_ready(match_order(config))
        from core.keepaway.viewed_match import ViewedMatch

        return ViewedMatch(config, policy if saved is None else saved.sarsa(), root_seed, "watch")

    screen = WatchScreen(
        heading(policy, saved, config, root_seed),
        length_m=config.length_m,
        width_m=config.width_m,
        speed=speed,
        episodes=episodes,
        detail=next((known for known in DETAILS if known == detail), None),
    )
    run(WatchApp(screen, prepare))


def _refuse(context: click.Context, names: tuple[str, ...], why: str) -> None:
    """Stop where options were given that have no meaning here."""
    given = [
        f"--{name}" for name in names if context.get_parameter_source(name) == ParameterSource.COMMANDLINE
    ]
    if given:
        raise click.UsageError(f"{', '.join(given)}: {why}")


def run(app: "WatchApp") -> None:
    """Run the app to its end and print what was seen."""
    told = app.run_in_terminal()
    if app.ended_by is not None:
        sys.stdout.flush()
        os._exit(128 + app.ended_by)  # without waiting for what is being compiled
    if app.trouble is not None:
        raise click.ClickException(str(app.trouble))
    app.stop_if_it_failed()
    if told is not None:
        say(told)
    if app.thread.is_alive():
        # The viewer left before everything was compiled: nothing is lost by not waiting for that.
        sys.stdout.flush()
        os._exit(0)


def get_ready(order: "Order") -> None:
    """Load all that an order asks for; where it is not compiled, let Python play until it is."""
    from arl_tui.ahead import Ahead, fill
    from arl_tui.app.compile_order import is_compiled
    from core.numerics.interpreting import (
        CAN_INTERPRET,
        load_interpreted,
        start_interpreting,
        stop_interpreting,
    )

    if is_compiled(order) or not CAN_INTERPRET:
        fill(order)
        return
    start_interpreting()
    ahead = Ahead(order)
    atexit.register(ahead.close)

    def change_over() -> None:
        ahead.wait()
        load_interpreted()
        stop_interpreting()

    threading.Thread(target=change_over, name="change over", daemon=True).start()


def read_policy(path: Path) -> "SavedPolicy":
    """Read a policy; stop with a message where the file cannot be used."""
    if not path.exists():
        raise click.BadParameter(
            f"{str(path)!r} is neither one of {', '.join(BENCHMARKS)} nor a file; "
            "`arl train keepaway --save FILE` makes one",
            param_hint="--policy",
        )
    from core.keepaway.policy_file import PolicyFileError, load_policy

    try:
        if path.suffix == ".jsonl":
            from core.keepaway.recorded_policy import recorded_policy

            return recorded_policy(path)
        return load_policy(path)
    except (PolicyFileError, OSError) as error:
        raise click.ClickException(str(error)) from error


def task(
    saved: "SavedPolicy | None",
    *,
    keepers: int | None,
    takers: int | None,
    size: tuple[float, float] | None,
    vision: str | None,
) -> "KeepawayConfig":
    """Return the task that is asked for: the file's, or the paper's, but for what is given."""
    from msgspec.structs import replace

    from core.keepaway.pitch import KeepawayConfig

    config = KeepawayConfig() if saved is None else saved.header.task
    wanted = (keepers or config.n_keepers, takers or config.n_takers)
    if saved is not None and wanted != (config.n_keepers, config.n_takers):
        raise click.ClickException(
            f"this policy was learned by {config.n_keepers} keepers against {config.n_takers} takers and "
            f"knows nothing else; got --keepers {wanted[0]} --takers {wanted[1]}"
        )
    try:
        config = replace(config, n_keepers=wanted[0], n_takers=wanted[1])
        if size is not None:
            config = replace(config, length_m=size[0], width_m=size[1])
        if vision is not None:
            exact = vision == "exact"
            config = replace(config, exact_state=exact, view_angle_deg=360.0 if exact else float(vision))
    except ValueError as error:
        raise click.ClickException(str(error)) from error
    return config


def heading(policy: str, saved: "SavedPolicy | None", config: "KeepawayConfig", seed: int) -> str:
    """Return what is watched, in lines of at most 34 characters, in markup."""
    from rich.markup import escape

    from core.system.foreign_text import printable

    lines = [
        (
            f"[b]Keepaway {config.n_keepers} against {config.n_takers}[/], {config.length_m:g} m x "
            f"{config.width_m:g} m"
        )
    ]
    if saved is None:
        lines.append(f"Policy   {BENCHMARKS[policy]}")
    else:
        header = saved.header
        lines += [
            f"Policy   {escape(printable(Path(policy).name)[:25])}",
            f"         {header.hours:.3g} h Sarsa, {header.episodes:,} episodes"[:34],
        ]
    lines.append(f"Players  see {sight(config)}")
    lines.append(f"Seed     {seed}")
    return "\n".join(lines)


def sight(config: "KeepawayConfig") -> str:
    """Say what players see."""
    if config.exact_state:
        return "everything exactly"
    return "all round" if config.view_angle_deg >= 360 else f"{config.view_angle_deg:g} degrees"
