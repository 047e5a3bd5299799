"""The tidy tables of what happened in sessions: steps, presses, credit, frames, interruptions, questions."""

from studies.exports.columns import Column, Table
from studies.exports.shared_columns import (
    ACTION,
    GAME,
    KEYS,
    PIECE,
    STEP,
    boolean,
    integer,
    number,
    seconds,
    text,
)
from studies.exports.words import PIECES

STEPS = Table(
    "steps",
    "a step of a watched game.",
    (
        *KEYS,
        GAME,
        STEP,
        integer("step_index", "Number of the step in the session, from 0, as in the recording."),
        seconds("decided_s", "When the agent decided."),
        seconds("shown_s", "When its first frame was handed to the terminal; empty if it never was."),
        seconds("hidden_s", "When it went off the screen for the last time; empty if it never did."),
        seconds("on_screen_s", "How long it was on screen, pauses left out."),
        PIECE,
        text("actor", "Who acted: a keeper, counted from 1; empty in Tetris."),
        ACTION,
        integer("action_index", "The action among the choices of the state, from 0; empty in imported logs."),
        integer(
            "environment_action_index",
            "What the environment policy alone would have done, from 0; empty in imported logs.",
        ),
        integer(
            "human_action_index",
            "What the human policy alone would have done, from 0; empty while there was none.",
        ),
        boolean("agreed", "Whether both policies chose the same; empty while there was no human policy."),
        integer("orientation", "Tetris: orientation of the piece, from 1; else empty."),
        integer("column", "Tetris: column of its left edge, from 1 at the left; else empty."),
        integer(
            "cycle_index", "Keepaway: simulator cycles (0.1 s each) since the kick-off; else empty.", "0.1 s"
        ),
        number(
            "reward",
            "Environmental reward. Tetris: lines cleared. Keepaway: seconds until the next decision.",
        ),
        text(
            "state_json",
            "What the decision was taken on, as a JSON list, where it was recorded; in imported logs the "
            "boards before and after; else empty.",
        ),
        integer(
            "presses_credited", "Counted presses of which it got a share; empty in imported logs.", "presses"
        ),
        number(
            "feedback", "Sum of value times share over these presses; 0 without any, empty in imported logs."
        ),
    ),
)
_VERDICTS = {
    "accepted": "counts",
    "other": "the key means nothing",
    "repeat": "a held key's repeat, or too soon after the last press",
    "no-presses-left": "the game's presses were used up",
    "covered": "the step was covered by a pause or a page",
    "not-playing": "no game was on screen",
}
PRESSES = Table(
    "presses",
    "a key press, also one that did not count.",
    (
        *KEYS,
        Column(
            "game",
            "integer",
            "The watched game on screen, or the last one before; from 1. Empty before the first.",
        ),
        Column("step", "integer", "The step of that game on screen, from 1; empty between games."),
        integer("press_index", "Number of the press in the session, from 0, as in the recording."),
        integer("step_index", "Number of that step in the session, from 0; empty between games."),
        seconds("time_s", "When the terminal's bytes were read."),
        seconds("since_shown_s", "Time since the step on screen was first shown; empty between games."),
        seconds(
            "since_frame_s",
            "Time since the frame on screen was handed to the terminal; in imported evaluations, since the "
            "event that "
            "the press judges. Empty before the first frame.",
        ),
        text("key", "Name of the key."),
        text(
            "read_as",
            "The letter on this key in the Latin layout, where `key` is of another one; else empty.",
        ),
        text("layout", "The keyboard layout by which `read_as` was found; else empty."),
        number("value", "Feedback meant: > 0 good, < 0 bad, 0 neither; empty for other keys."),
        text(
            "judgement",
            "The sign of `value`; empty for other keys.",
            good="value > 0",
            bad="value < 0",
            neither="value = 0",
        ),
        Column("verdict", "text", "Whether it was accepted, or why not.", levels=_VERDICTS),
        boolean("counted", "Whether it was accepted and not taken back."),
        text(
            "retracted",
            "By whom it was taken back; empty if it was not.",
            participant="by a key",
            auto_repeat="it opened the run of a held key",
        ),
        seconds("retracted_s", "When; empty if it was not."),
        boolean("asked_wrong", "Whether the participant had been asked to press the wrong key deliberately."),
        text("pressed_by", "Who pressed.", participant="", simulated=""),
        integer(
            "person",
            "Which of several people at one keyboard, or of several simulated participants, from 1; 1 where "
            "one participates, empty for a key of nobody.",
        ),
        integer("frame_index", "Frame on screen, from 0; empty before the first."),
        Column(
            "piece",
            "text",
            "The piece of the step on screen; empty outside Tetris and between games.",
            levels={name: "" for name in PIECES},
        ),
        text("action", "The action of the step on screen, in words; empty between games."),
        integer("credited_steps", "Steps of which each got a share.", "steps"),
        integer(
            "credited_step_index", "Number of the step with the largest share, from 0; empty without any."
        ),
        number("credited_share", "That share, 0 to 1; empty without any."),
        number(
            "before_first",
            "Mass that fell before the first watched step, 0 to 1; empty if it was not credited.",
        ),
        number(
            "in_gaps", "Mass that fell into pauses and between games, 0 to 1; empty if it was not credited."
        ),
        number(
            "too_late",
            "Mass of steps whose sample had been given out already, 0 to 1; empty if it was not credited.",
        ),
        integer(
            "merged_into_index",
            "The press that opened the burst of which it is part; empty if it is of none.",
        ),
        number("trust", "`trust_before` of its game."),
        number("weight", "`weight` of its game."),
    ),
)
CREDIT = Table(
    "credit",
    "a step's share of a press.",
    (
        *KEYS,
        integer("game", "The watched game of the step, from 1."),
        STEP,
        integer("press_index", "Number of the press in the session, from 0."),
        integer("step_index", "Number of the step in the session, from 0."),
        boolean("counted", "Whether the press was not taken back."),
        number("value", "Feedback meant by the press."),
        number("share", "The step's share, 0 to 1."),
        number("feedback", "value times share."),
        seconds("after_shown_s", "From when the step was first shown to the press; empty if it never was."),
        seconds(
            "after_hidden_s",
            "From when the step went off the screen to the press; negative while it was on it; empty if it "
            "never did.",
        ),
        PIECE,
        ACTION,
    ),
)
FRAMES = Table(
    "frames",
    "a frame with new content that was handed to the terminal.",
    (
        *KEYS,
        Column(
            "game",
            "integer",
            "The watched game on screen, or the last one before; from 1. Empty before the first.",
        ),
        Column("step", "integer", "The step of that game on screen, from 1; empty when none is."),
        integer("frame_index", "Number of the frame in the session, from 0."),
        integer("step_index", "Number of the step in the session, from 0; empty when none is."),
        seconds("flushed_s", "When its last byte was handed to the terminal."),
        seconds("since_last_s", "Time since the frame before; empty for the first."),
    ),
)
INTERRUPTIONS = Table(
    "interruptions",
    "something that happened to the screen, the window or the program, or a cue.",
    (
        *KEYS,
        Column(
            "game",
            "integer",
            "The watched game on screen, or the last one before; from 1. Empty before the first.",
        ),
        Column(
            "event",
            "text",
            "What happened.",
            levels={
                "screen-cleared": "the step on screen was covered",
                "resumed": "the participant came back",
                "time-gap": "the program stood still",
                "focus-lost": "the window no longer received keys",
                "focus-regained": "it received keys again",
                "wrong-press-asked": "the participant was asked to press the wrong key once",
                "stop-asked": "the session was to end",
            },
        ),
        seconds("time_s", "When; of a time-gap, when the program ran again."),
        text("reason", "Why; empty where the event has no reason."),
        seconds(
            "stood_still_s",
            "Of a time-gap: how long the program did not run, without the time the machine slept; else "
            "empty.",
        ),
        seconds("suspended_s", "Of a time-gap: how long the machine slept; else empty."),
    ),
)
QUESTIONS = Table(
    "questions",
    "a question that the agent posed, and its answer.",
    (
        *KEYS,
        GAME,
        STEP,
        integer("question_index", "Number of the question in the session, from 0, as in the recording."),
        integer("step_index", "The step that was asked about, from 0; it is decided after the answer."),
        integer("options", "How many actions were offered.", "actions"),
        text("options_json", "The actions offered, from 0, in the order of their keys."),
        text("option_1", "The first option in words; empty where the game has none."),
        text("option_2", "The second one."),
        text("option_3", "The third one; empty where two were offered."),
        number("disagreement", "How unsure the agent was, in [0, 1]."),
        text(
            "answer",
            "What came of it; empty where the session ended before.",
            chosen="an option was chosen",
            none="the key for none of them was pressed",
            time_limit="nobody answered in time",
        ),
        integer("chosen_index", "The action that was chosen, from 0; empty where none was."),
        integer("chosen_option", "Which option that is, from 1; empty where none was.", "options"),
        boolean("followed", "Whether the agent then did what was chosen; empty where nothing was."),
        integer("press_index", "The press that gave the answer; empty without one."),
        seconds("posed_s", "When the agent posed it; the game stood still from then on."),
        seconds("shown_s", "When its options were handed to the terminal; empty without an answer."),
        seconds("answered_s", "When the key was pressed, or the time was up."),
        seconds("latency_s", "From the options on screen to the key; empty where no key was pressed."),
    ),
)
