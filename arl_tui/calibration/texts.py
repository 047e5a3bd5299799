"""What the participant is told, in plain words."""

from arl_tui.games.registry import screens_called
from arl_tui.language import key_for, key_name, later, tr
from arl_tui.words import judging_text
from studies.reaction_time.protocol import Task, TaskConfig, TrialRecord

TITLES: dict[Task, str] = {
    "simple": later("React"),
    "choice": later("Left or right"),
    "go/no-go": later("Press or hold back"),
    "memory search": later("Was it there?"),
    "visual search": later("Find the T"),
    "recognition": later("Old or new word"),
    "feedback lag": later("Judge the computer"),
}
INSTRUCTIONS: dict[Task, str] = {
    "simple": later(
        "Look at the small cross. After a while a large [b]X[/] appears instead of it.\n\n"
        "Press {space} as soon as you see it."
    ),
    "choice": later(
        "Look at the small cross. After a while an arrow appears instead of it.\n\n"
        "Arrow to the left:  press {no}\nArrow to the right: press {yes}"
    ),
    "go/no-go": later(
        "Look at the small cross. After a while a ring [b]O[/] or a cross [b]X[/] appears.\n\n"
        "Ring:  press {space} as soon as you see it\nCross: press nothing, and wait"
    ),
    "memory search": later(
        "You see a few letters, one after another: keep them in mind. Then a small cross, then one more "
        "letter.\n\n"
        "It was among them:     press {yes}\nIt was not among them: press {no}"
    ),
    "visual search": later(
        "After a small cross many letters appear, nearly all of them [b]L[/].\n\n"
        "There is a [b]T[/] among them: press {yes}\nThere is none:           press {no}"
    ),
    "recognition": later(
        "First you see a list of words, one after another: keep them in mind. Then words come one by one, "
        "each after a small cross.\n\nThe word was in the list:     press {yes}\n"
        "The word was not in the list: press {no}"
    ),
}


def instruction(config: TaskConfig) -> str:
    """Return how a task goes, in markup."""
    if config.task == "feedback lag":
        return judging_text(screens_called(config.game).judging.instruction)
    return judging_text(INSTRUCTIONS[config.task])


def key_reminder(config: TaskConfig) -> str:
    """Return which key says what, in markup."""
    if config.task == "feedback lag":
        return judging_text(screens_called(config.game).judging.reminder)
    return judging_text(KEY_REMINDERS[config.task])


SOMETIMES_NOTHING = later(
    "Be quick, but wait until you really see something: [b]now and then nothing comes[/], and then nothing "
    "is to be pressed."
)
KEY_REMINDERS: dict[Task, str] = {
    "simple": later("{space} when you see X"),
    "choice": later("{no} left    {yes} right"),
    "go/no-go": later("{space} at O    nothing at X"),
    "memory search": later("{no} not among them    {yes} among them"),
    "visual search": later("{no} no T    {yes} a T"),
    "recognition": later("{no} new    {yes} in the list"),
}
LET_GO = later("Please let go of the key.")


def session_keys() -> str:
    """Return the keys that interrupt the trials, in markup."""
    pause, stop = (f"[b]{key_name(key_for(action))}[/]" for action in ("pause", "stop"))
    return f"{pause} {tr('pause')}   {stop} {tr('stop')}"


def practice_word(record: TrialRecord) -> str:
    """Return what the participant is told after a practice trial, in markup."""
    if not record.expected_keys:
        if record.key is None:
            return f"[$text-success]{tr('Right: nothing was to be pressed.')}[/]"
        if record.catch:
            return warned(tr("Nothing had come: wait next time."))
        return warned(tr("This was the one to hold back at: wait next time."))
    if record.early_presses and record.status != "ok":
        return warned(tr("Too early: wait until you see it."))
    match record.status:
        case "ok":
            assert record.rt_s is not None
            took = tr("{ms:.0f} thousandths of a second", ms=record.rt_s * 1000)
            return f"[$text-success]{took}[/]"
        case "anticipation":
            return warned(tr("Too early: wait until you see it."))
        case "time-out":
            return warned(tr("Too slow."))
        case "wrong key":
            if record.task == "feedback lag":
                return warned(tr("Most people would say the opposite."))
            return warned(tr("The other key."))
        case "repeat":
            return warned(tr(LET_GO))


def warned(text: str) -> str:
    """Return a text as what went wrong in a practice trial, in markup."""
    return f"[$text-warning]{text}[/]"
