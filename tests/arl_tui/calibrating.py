"""A scripted participant of a calibration, and work of other processes done in this one."""

import asyncio
from collections.abc import Callable, Sequence
from pathlib import Path

import msgspec
from textual.pilot import Pilot
from textual.screen import Screen

from arl_tui.calibration import app as calibration_app
from arl_tui.calibration.app import CalibrationApp
from arl_tui.calibration.fitting import fit_files
from arl_tui.calibration.plan import TASKS, CalibrationSetup
from arl_tui.calibration.trial_screen import TrialScreen
from arl_tui.games.tetris.judging import make_positions
from studies.reaction_time.protocol import Foreperiod, TaskConfig, TrialPlan
from studies.reaction_time.trial import TrialTiming
from studies.reaction_time.trial_log import TrialFile, read_trials

QUICK = TrialTiming(quiet_ms=20, late_mail_ms=20)
MOMENT = Foreperiod(least_s=0.05, mean_extra_s=0.02, most_s=0.1)
A_WHILE = Foreperiod(least_s=0.8, mean_extra_s=0.1, most_s=1.0)
"""Long enough to do something in it."""
PATIENCE_S = 300.0
SILENCE_S = 0.4
"""A time-out for trials that nobody is to answer; the others' is too long for a busy machine to reach."""

Answer = Callable[[TrialPlan], Sequence[str]]
"""Keys that are pressed when a stimulus is on screen."""


def right(plan: TrialPlan) -> Sequence[str]:
    """Answer as one should."""
    return plan.expected_keys[:1]


def quick(name: str, **changes) -> TaskConfig:
    """Return a task that takes no time if it is answered."""
    given = {
        "n_practice": 0,
        "n_trials": 2,
        "catch_rate": 0.0,
        "foreperiod": MOMENT,
        "time_out_s": 30.0,
        "study_item_s": 0.05,
    }
    return TaskConfig(task=TASKS[name], **{**given, **changes})


def setup(
    folder: Path, *configs: TaskConfig, seed: int = 3, hindrances: tuple[str, ...] = ()
) -> CalibrationSetup:
    """Return the setup of a calibration of P01."""
    return CalibrationSetup(
        participant="P01",
        configs=configs or (quick("simple"),),
        root_seed=seed,
        recordings=folder,
        hindrances=hindrances,
    )


async def in_this_process(module: str, question: object) -> bytes:
    """Do what the helper processes do."""
    await asyncio.sleep(0.01)
    if module.endswith("scenes"):
        return msgspec.json.encode(make_positions(question))
    return msgspec.json.encode(fit_files(question))


def quick_app(given: CalibrationSetup, **options) -> CalibrationApp:
    """Return an app that waits for nobody."""
    options.setdefault("helper", in_this_process)
    return CalibrationApp(given, timing=QUICK, **options)


def plan_number(plan: TrialPlan) -> int:
    """Return a number that scatters over the trials."""
    return plan.index * 7 + 3


async def until(pilot: Pilot, condition: Callable[[], bool]) -> None:
    """Wait for something to happen on the screen."""
    loop = asyncio.get_running_loop()
    end = loop.time() + PATIENCE_S
    while not condition():
        assert loop.time() < end, f"nothing happened on {type(pilot.app.screen).__name__}"
        await asyncio.sleep(0.005)


def shows(pilot: Pilot, kind: type[Screen]) -> Callable[[], bool]:
    """Return whether such a screen is shown, as a condition."""
    return lambda: isinstance(pilot.app.screen, kind)


def trial_in(pilot: Pilot, *phases: str) -> Callable[[], bool]:
    """Return whether a trial is in one of these phases, as a condition."""

    def holds() -> bool:
        screen = pilot.app.screen
        return isinstance(screen, TrialScreen) and screen._trial is not None and screen._trial.phase in phases

    return holds


async def go_through(
    pilot: Pilot, answer: Answer = right, *, until_shown: type[Screen] | None = None
) -> None:
    """Read every page, answer every trial, up to the end or to a page of a kind."""
    answered: set[tuple[int, int]] = set()
    app = pilot.app
    end = asyncio.get_running_loop().time() + PATIENCE_S
    while app.is_running and app.return_value is None:
        assert asyncio.get_running_loop().time() < end, f"stuck on {type(app.screen).__name__}"
        screen = app.screen
        if until_shown is not None and isinstance(screen, until_shown):
            return
        if isinstance(screen, TrialScreen):
            trial = screen._trial
            if (
                trial is not None
                and trial.phase == "shown"
                and (id(screen), trial.plan.index) not in answered
            ):
                answered.add((id(screen), trial.plan.index))
                # As people are: never equally fast, and not before 0.1 s.
                await asyncio.sleep(0.12 + 0.03 * (plan_number(trial.plan) % 4))
                for key in answer(trial.plan):
                    await pilot.press(key)
            await asyncio.sleep(0.005)
        elif type(screen).__module__ == calibration_app.WelcomePage.__module__:
            await pilot.press("enter")
            await asyncio.sleep(0.01)
        else:
            await asyncio.sleep(0.005)


def files_in(folder: Path) -> list[TrialFile]:
    """Return all trial files in the order of their names."""
    return [read_trials(path) for path in sorted((folder / "calibration").glob("*.jsonl"))]
