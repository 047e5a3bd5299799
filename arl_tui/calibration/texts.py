"""What the participant is told, in plain words."""

from arl_tui.games.registry import screens_called
from arl_tui.words import cap
from studies.reaction_time.protocol import NO, YES, Task, TaskConfig, TrialRecord

TITLES: dict[Task, str] = {
    "simple": "React",
    "choice": "Left or right",
    "go/no-go": "Press or hold back",
    "memory search": "Was it there?",
    "visual search": "Find the T",
    "recognition": "Old or new word",
    "feedback lag": "Judge the computer",
}
INSTRUCTIONS: dict[Task, str] = {
    "simple": (
        "Look at the small cross. After a while a large [b]X[/] appears instead of it.\n\n"
        f"Press {cap('space')} as soon as you see it."
    ),
    "choice": (
        "Look at the small cross. After a while an arrow appears instead of it.\n\n"
        f"Arrow to the left:  press {cap(NO)}\nArrow to the right: press {cap(YES)}"
    ),
    "go/no-go": (
        "Look at the small cross. After a while a ring [b]O[/] or a cross [b]X[/] appears.\n\n"
        f"Ring:  press {cap('space')} as soon as you see it\nCross: press nothing, and wait"
    ),
    "memory search": (
        "You see a few letters, one after another: keep them in mind. Then a small cross, then one more "
        "letter.\n\n"
        f"It was among them:     press {cap(YES)}\nIt was not among them: press {cap(NO)}"
    ),
    "visual search": (
        "After a small cross many letters appear, nearly all of them [b]L[/].\n\n"
        f"There is a [b]T[/] among them: press {cap(YES)}\nThere is none:           press {cap(NO)}"
    ),
    "recognition": (
        "First you see a list of words, one after another: keep them in mind. Then words come one by one, "
        f"each after a small cross.\n\nThe word was in the list:     press {cap(YES)}\n"
        f"The word was not in the list: press {cap(NO)}"
    ),
}


def instruction(config: TaskConfig) -> str:
    """Return how a task goes, in markup."""
    if config.task == "feedback lag":
        return screens_called(config.game).judging.instruction
    return INSTRUCTIONS[config.task]


def key_reminder(config: TaskConfig) -> str:
    """Return which key says what, in markup."""
    if config.task == "feedback lag":
        return screens_called(config.game).judging.reminder
    return KEY_REMINDERS[config.task]


SOMETIMES_NOTHING = (
    "Be quick, but wait until you really see something: [b]now and then nothing comes[/], and then nothing "
    "is to be pressed."
)
KEY_REMINDERS: dict[Task, str] = {
    "simple": f"{cap('space')} when you see X",
    "choice": f"{cap(NO)} left    {cap(YES)} right",
    "go/no-go": f"{cap('space')} at O    nothing at X",
    "memory search": f"{cap(NO)} not among them    {cap(YES)} among them",
    "visual search": f"{cap(NO)} no T    {cap(YES)} a T",
    "recognition": f"{cap(NO)} new    {cap(YES)} in the list",
}
SESSION_KEYS = "[b]P[/] pause   [b]Q[/] stop"
LET_GO = "Please let go of the key."


def practice_word(record: TrialRecord) -> str:
    """Return what the participant is told after a practice trial, in markup."""
    if not record.expected_keys:
        if record.key is None:
            return "[$text-success]Right: nothing was to be pressed.[/]"
        shown = "Nothing had come" if record.catch else "This was the one to hold back at"
        return f"[$text-warning]{shown}: wait next time.[/]"
    if record.early_presses and record.status != "ok":
        return "[$text-warning]Too early: wait until you see it.[/]"
    match record.status:
        case "ok":
            assert record.rt_s is not None
            return f"[$text-success]{record.rt_s * 1000:.0f} thousandths of a second[/]"
        case "anticipation":
            return "[$text-warning]Too early: wait until you see it.[/]"
        case "time-out":
            return "[$text-warning]Too slow.[/]"
        case "wrong key":
            other = (
                "Most people would say the opposite." if record.task == "feedback lag" else "The other key."
            )
            return f"[$text-warning]{other}[/]"
        case "repeat":
            return f"[$text-warning]{LET_GO}[/]"
