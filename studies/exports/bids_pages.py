"""Texts of a BIDS data set: columns of events, tasks, instructions, stimuli."""

from collections.abc import Collection
from pathlib import Path

from core.system.private_files import make_private_folder
from core.tetris.shapes import ORIENTATION_ROWS
from studies.exports.columns import Column
from studies.exports.event_tables import PRESSES, STEPS
from studies.exports.tables import PLAYED as GAMES
from studies.exports.words import PIECES

_EVENT_TYPES = {
    "game": "a watched game, from its beginning to its end",
    "step": "one step of a game on screen: a piece, or a decision of a keeper",
    "press": "a key press, also one that did not count",
}
HED_VERSION = "8.3.0"
HED = {
    "game": "Experiment-structure",
    "step": "Sensory-event, Visual-presentation, Experimental-stimulus",
    "press": "Agent-action, Participant-response, (Press, Keyboard-key)",
}
"""What kind of event each `trial_type` is, in Hierarchical Event Descriptors."""
_BY_NAME = {column.name: column for table in (GAMES, STEPS, PRESSES) for column in table.columns}
_TAKEN = [
    "game",
    "step",
    "piece",
    "action",
    "actor",
    "reward",
    "feedback",
    "presses_credited",
    "key",
    "value",
    "judgement",
    "verdict",
    "counted",
    "retracted",
    "asked_wrong",
    "pressed_by",
    "performance",
    "trust_before",
    "trust_after",
    "weight",
    "condition",
    "sitting",
]
COLUMNS: tuple[Column, ...] = (
    Column("onset", "number", "When the event began, since the session began. A step that was never shown: when it was decided.", "s"),  # noqa: E501
    Column("duration", "number", "How long it lasted, pauses left out; 0 for a press; n/a where it is not known.", "s"),  # noqa: E501
    Column("trial_type", "text", "What kind of event it is.", levels=_EVENT_TYPES),
    Column("response_time", "number", "Of a press: time since the step on screen was first shown; in imported evaluations, since the event judged.", "s"),  # noqa: E501
    Column("stim_file", "text", "Of a step: the drawing of its stimulus, below /stimuli."),
    *(_BY_NAME[name] for name in _TAKEN),
)  # fmt: skip
"""Columns of `_events.tsv`."""
TASKS = {
    "tetris": "The participant watches an agent play Tetris in a text terminal and judges its last move by key presses.",  # noqa: E501
    "keepaway": "The participant watches agents play Keepaway in a text terminal and judges the last pass by key presses.",  # noqa: E501
    "judging": "The participant judges what an agent does by key presses.",
    "trials": "Reaction-time trials in a text terminal: a foreperiod, a stimulus, and a key.",
}
INSTRUCTIONS = {
    "tetris": "Tell the computer what you think of where the last piece came to rest: one key for good, one for bad.",  # noqa: E501
    "keepaway": "Tell the team what you think of its last pass, or of holding the ball too long: one key for good, one for bad.",  # noqa: E501
    "judging": "Not recorded.",
    "trials": "Press the key as fast as you can when the stimulus appears.",
}
README = """# Key presses on an agent's play, and reaction times

Made by `arl export bids` (arl-tui). Each session of watching is a `_events.tsv` file in its participant's folder: games,
steps and key presses in the order of their onsets. Each file of reaction trials is a `_beh.tsv` file. The JSON files
at the top say what each column means, its unit and its levels.

Times are seconds of a monotonic clock since the session began. A press's time is when the terminal's bytes were
read; a step's onset is when its first frame was handed to the terminal. The delay of the display itself is not in them.

Stimuli are text drawings: `stimuli/` holds them. Dates and texts that people typed are left out unless they were asked for.
"""  # noqa: E501
KEEPAWAY = """Keepaway: a square field drawn in a text terminal. K marks a keeper, T a taker, a dot the ball. The keepers pass the
ball among themselves; an episode ends when a taker has it or it leaves the square. The whole field is redrawn at most
30 times a second.
"""  # noqa: E501


def write_stimuli(folder: Path, tasks: Collection[str]) -> None:
    """Write the drawings that `stim_file` names: each piece in each of its orientations, from above."""
    if "tetris" in tasks:
        make_private_folder(folder / "tetris")
        for piece, orientations in zip(PIECES, ORIENTATION_ROWS, strict=True):
            for number, rows in enumerate(orientations, start=1):
                (folder / "tetris" / f"{piece}-{number}.txt").write_text(_drawing(rows), encoding="utf-8")
    if "keepaway" in tasks:
        make_private_folder(folder)
        (folder / "keepaway.txt").write_text(KEEPAWAY, encoding="utf-8")


def _drawing(rows: tuple[int, ...]) -> str:
    """Return a piece drawn with #, top row first; `rows` are bit masks, lowest row first, bit 0 at the
    left.
    """
    width = max(rows).bit_length()
    lines = ["".join("#" if row >> column & 1 else "." for column in range(width)) for row in reversed(rows)]
    return "\n".join(lines) + "\n"
