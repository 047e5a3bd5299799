"""Columns that several tidy tables share, and short ways to declare a column."""

from studies.exports.columns import Column
from studies.exports.words import GAMES, PIECES


def text(name: str, meaning: str, **levels: str) -> Column:
    """Return a column of texts; `levels` are its values and their meanings, with "_" for "-"."""
    return Column(
        name, "text", meaning, levels={level.replace("_", "-"): said for level, said in levels.items()}
    )


def integer(name: str, meaning: str, unit: str = "") -> Column:
    """Return a column of whole numbers."""
    return Column(name, "integer", meaning, unit)


def number(name: str, meaning: str, unit: str = "") -> Column:
    """Return a column of numbers."""
    return Column(name, "number", meaning, unit)


def seconds(name: str, meaning: str) -> Column:
    """Return a column of seconds."""
    return Column(name, "number", meaning, "s")


def boolean(name: str, meaning: str) -> Column:
    """Return a column of truth values."""
    return Column(name, "boolean", meaning)


ORIGINS = {
    "live": "a participant at a terminal",
    "simulated": "a simulated participant",
    "imported": "another program's log",
}
WHOSE = (
    text(
        "participant",
        "Code of the participant; of a press of several people at one keyboard, of the one who pressed.",
    ),
    text(
        "session", "Name of the file, with the folders below the one that was exported, without its ending."
    ),
    text("study", "Name of the study; empty outside one."),
    text(
        "condition",
        "Condition of the study; of imported evaluations, the columns by which they were divided; else "
        "empty.",
    ),
    integer("sitting", "Which visit of the participant, from 1; empty outside a study."),
    integer("place", "The participant's place in the order of assignment, from 1; empty outside a study."),
)
KEYS = (
    *WHOSE,
    Column("origin", "text", "Who pressed.", levels=ORIGINS),
    Column(
        "domain",
        "text",
        "Which game is played; empty where an imported table does not say.",
        levels={name: "" for name in GAMES},
    ),
)
GAME = integer("game", "Which watched game of the session, from 1.")
STEP = integer("step", "Which step of its game, from 1 (Tetris: piece; Keepaway: decision).")
PIECE = Column(
    "piece", "text", "The piece that was placed; empty outside Tetris.", levels={name: "" for name in PIECES}
)
ACTION = text("action", "What was done, in words; empty where an imported log does not say.")
