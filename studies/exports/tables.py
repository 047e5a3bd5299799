"""The tidy tables: every column with its unit, its levels and its meaning. The codebook is made from this."""

from studies.exports.columns import Column, Table
from studies.exports.words import GAMES, PIECES


def _text(name: str, meaning: str, **levels: str) -> Column:
    return Column(
        name, "text", meaning, levels={level.replace("_", "-"): text for level, text in levels.items()}
    )


def _integer(name: str, meaning: str, unit: str = "") -> Column:
    return Column(name, "integer", meaning, unit)


def _number(name: str, meaning: str, unit: str = "") -> Column:
    return Column(name, "number", meaning, unit)


def _seconds(name: str, meaning: str) -> Column:
    return Column(name, "number", meaning, "s")


def _boolean(name: str, meaning: str) -> Column:
    return Column(name, "boolean", meaning)


_ORIGINS = {
    "live": "a person at a terminal",
    "simulated": "a simulated participant",
    "imported": "another program's log",
}
_SESSION = (
    _text("participant", "Code of the participant."),
    _text(
        "session", "Name of the file, with the folders below the one that was exported, without its ending."
    ),
    _text("study", "Name of the study; empty outside one."),
    _text("condition", "Condition of the study; empty outside one."),
    _integer("sitting", "Which visit of the participant, from 1; empty outside a study."),
    _integer("place", "The participant's place in the order of assignment, from 1; empty outside a study."),
)
KEYS = (
    *_SESSION,
    Column("origin", "text", "Who pressed.", levels=_ORIGINS),
    Column("domain", "text", "Which game is played.", levels={name: "" for name in GAMES}),
)
_GAME = _integer("game", "Which watched game of the session, from 1.")
_STEP = _integer("step", "Which step of its game, from 1 (Tetris: piece; Keepaway: decision).")
_PIECE = Column(
    "piece", "text", "The piece that was placed; empty outside Tetris.", levels={name: "" for name in PIECES}
)
_ACTION = _text("action", "What was done, in words; empty where an imported log does not say.")

SESSIONS = Table(
    "sessions",
    "a recorded session.",
    (
        *KEYS,
        _text("created_utc", "Wall-clock time of the start, ISO 8601; a remark in anonymised files."),
        _seconds("duration_s", "From the start to the last recorded time."),
        _text(
            "ended",
            "How it ended: finished, participant, window-closed, signal, worker-died, time-limit, "
            "disk-failed, killed, cut, closed or imported (see `arl recordings`).",
        ),
        _integer("games_planned", "Watched games of the protocol; empty in imported logs.", "games"),
        _integer("games_begun", "Watched games that began.", "games"),
        _integer("games_finished", "Watched games that were not broken off by the session's end.", "games"),
        _integer("games_unseen", "Games that were played without a screen.", "games"),
        _integer("steps", "Watched steps.", "steps"),
        _integer("presses_counted", "Presses that were accepted and not taken back.", "presses"),
        _integer("presses_retracted", "Accepted presses that were taken back.", "presses"),
        _text("protocol", "Name of the protocol."),
        _text("learner", "Type of the environment's learner."),
        _text("scheme", "How R and H are combined."),
        _text("trust_rule", "Rule of trust in the participant."),
        _text("human_model", "Type of the human reward model."),
        _text("credit_rule", "How a press is credited to steps, with its numbers."),
        _text("credit_scheme", "Whether each press is a sample, or each step."),
        _text("key_good", "Key that praises."),
        _text("key_bad", "Key that blames."),
        _integer("max_presses_per_game", "Presses accepted in a game.", "presses"),
        Column("root_seed", "text", "Root seed of the session: a whole number of up to 19 digits."),
        _integer("format_version", "Version of the recording's format in which the session was recorded."),
        _text(
            "program_version", "Version of the program that recorded it; empty where the file does not say."
        ),
    ),
)
SETTINGS = Table(
    "settings",
    "a setting of a session's protocol, defaults written out.",
    (
        *_SESSION,
        _text("setting", "Path of the setting in the protocol, such as `agent.credit.delay.shape`."),
        _text("value", "Its value, as JSON."),
    ),
)
PLAYED = Table(
    "games",
    "a game, watched or played without a screen.",
    (
        *KEYS,
        _integer("game", "Which watched game of the session, from 1; empty for unseen ones."),
        _boolean("watched", "Whether it was on screen."),
        _integer(
            "episode_index", "Number of the game among watched and unseen ones, from 0, as in the recording."
        ),
        _integer("policy_index", "Which of the learner's policies played, from 0."),
        _number(
            "performance",
            "Tetris: lines cleared. Keepaway: seconds the ball was kept. Empty where the session "
            "ended before the game did.",
        ),
        _text("performance_unit", "Unit of `performance`.", lines="", s="seconds"),
        _integer("steps", "Steps of the game.", "steps"),
        _text(
            "ended",
            "Why it ended; empty where the session ended before it did.",
            termination="by the rules of the game",
            truncation="after the most steps, or by the session's end",
        ),
        _seconds("started_s", "When it began; empty for unseen games."),
        _seconds("ended_s", "When its last step was over; empty for unseen games."),
        _seconds("duration_s", "From its beginning to its end; empty for unseen games."),
        _number(
            "trust_before",
            "What the rule of trust said of the participant when it began; empty for unseen games and where "
            "version 1 did not record it.",
        ),
        _number(
            "trust_after",
            "What the rule of trust said after it; of unseen games after the last of their group.",
        ),
        _number(
            "weight",
            "Weight w_h of the human's values that the scheme used; empty where version 1 did not record it.",
        ),
        _number("environment_weight", "Weight w_r of the environment's values; empty for unseen games."),
        _number(
            "share",
            "Probability of handing the choice to the human policy (control sharing), else 0; empty for unseen games.",
        ),
        _number(
            "shaping", "Added to the reward per unit of H (reward shaping), else 0; empty for unseen games."
        ),
        _number(
            "augmentation",
            "Weight of H in what the learner learns (Q augmentation), else 0; empty for unseen games.",
        ),
        _integer("agreed", "Steps at which environment and human policy chose the same.", "steps"),
        _integer(
            "agreed_worst",
            "Steps at which the environment policy chose the human policy's worst action.",
            "steps",
        ),
        _integer("presses_counted", "Presses made in it that were accepted and not taken back.", "presses"),
        _integer("presses_good", "Of these, praise.", "presses"),
        _integer("presses_bad", "Of these, blame.", "presses"),
    ),
)
STEPS = Table(
    "steps",
    "a step of a watched game.",
    (
        *KEYS,
        _GAME,
        _STEP,
        _integer("step_index", "Number of the step in the session, from 0, as in the recording."),
        _seconds("decided_s", "When the agent decided."),
        _seconds("shown_s", "When its first frame was handed to the terminal; empty if it never was."),
        _seconds("hidden_s", "When it went off the screen for the last time; empty if it never did."),
        _seconds("on_screen_s", "How long it was on screen, pauses left out."),
        _PIECE,
        _text("actor", "Who acted: a keeper, counted from 1; empty in Tetris."),
        _ACTION,
        _integer(
            "action_index", "The action among the choices of the state, from 0; empty in imported logs."
        ),
        _integer(
            "environment_action_index",
            "What the environment policy alone would have done, from 0; empty in imported logs.",
        ),
        _integer(
            "human_action_index",
            "What the human policy alone would have done, from 0; empty while there was none.",
        ),
        _boolean("agreed", "Whether both policies chose the same; empty while there was no human policy."),
        _integer("orientation", "Tetris: orientation of the piece, from 1; else empty."),
        _integer("column", "Tetris: column of its left edge, from 1 at the left; else empty."),
        _integer(
            "cycle_index", "Keepaway: simulator cycles (0.1 s each) since the kick-off; else empty.", "0.1 s"
        ),
        _number(
            "reward",
            "Environmental reward. Tetris: lines cleared. Keepaway: seconds until the next decision.",
        ),
        _text(
            "state_json", "What the decision was taken on, as a JSON list, where it was recorded; else empty."
        ),
        _integer("presses_credited", "Counted presses of which it got a share.", "presses"),
        _number("feedback", "Sum of value times share over these presses; 0 without any."),
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
        _integer("press_index", "Number of the press in the session, from 0, as in the recording."),
        _integer("step_index", "Number of that step in the session, from 0; empty between games."),
        _seconds("time_s", "When the terminal's bytes were read."),
        _seconds("since_shown_s", "Time since the step on screen was first shown; empty between games."),
        _text("key", "Name of the key."),
        _text(
            "read_as",
            "The letter on this key in the Latin layout, where `key` is of another one; else empty.",
        ),
        _text("layout", "The keyboard layout by which `read_as` was found; else empty."),
        _number("value", "Feedback meant: > 0 good, < 0 bad; empty for other keys."),
        _text("judgement", "The sign of `value`; empty for other keys.", good="value > 0", bad="value < 0"),
        Column("verdict", "text", "Whether it was accepted, or why not.", levels=_VERDICTS),
        _boolean("counted", "Whether it was accepted and not taken back."),
        _text(
            "retracted",
            "By whom it was taken back; empty if it was not.",
            participant="by a key",
            auto_repeat="it opened the run of a held key",
        ),
        _seconds("retracted_s", "When; empty if it was not."),
        _boolean(
            "asked_wrong", "Whether the participant had been asked to press the wrong key deliberately."
        ),
        _text("pressed_by", "Who pressed.", participant="", simulated=""),
        _integer("person", "Which simulated participant, from 1; 1 in live sessions."),
        _integer("frame_index", "Frame on screen, from 0; empty before the first."),
        Column(
            "piece",
            "text",
            "The piece of the step on screen; empty outside Tetris and between games.",
            levels={name: "" for name in PIECES},
        ),
        _text("action", "The action of the step on screen, in words; empty between games."),
        _integer("credited_steps", "Steps of which each got a share.", "steps"),
        _integer(
            "credited_step_index", "Number of the step with the largest share, from 0; empty without any."
        ),
        _number("credited_share", "That share, 0 to 1; empty without any."),
        _number(
            "before_first",
            "Mass that fell before the first watched step, 0 to 1; empty if it was not credited.",
        ),
        _number(
            "in_gaps", "Mass that fell into pauses and between games, 0 to 1; empty if it was not credited."
        ),
        _number(
            "too_late",
            "Mass of steps whose sample had been given out already, 0 to 1; empty if it was not credited.",
        ),
        _integer(
            "merged_into_index",
            "The press that opened the burst of which it is part; empty if it is of none.",
        ),
        _number("trust", "`trust_before` of its game."),
        _number("weight", "`weight` of its game."),
    ),
)
CREDIT = Table(
    "credit",
    "a step's share of a press.",
    (
        *KEYS,
        _integer("game", "The watched game of the step, from 1."),
        _STEP,
        _integer("press_index", "Number of the press in the session, from 0."),
        _integer("step_index", "Number of the step in the session, from 0."),
        _boolean("counted", "Whether the press was not taken back."),
        _number("value", "Feedback meant by the press."),
        _number("share", "The step's share, 0 to 1."),
        _number("feedback", "value times share."),
        _seconds("after_shown_s", "From when the step was first shown to the press; empty if it never was."),
        _seconds(
            "after_hidden_s",
            "From when the step went off the screen to the press; negative while it was on it; empty if it "
            "never did.",
        ),
        _PIECE,
        _ACTION,
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
        _integer("frame_index", "Number of the frame in the session, from 0."),
        _integer("step_index", "Number of the step in the session, from 0; empty when none is."),
        _seconds("flushed_s", "When its last byte was handed to the terminal."),
        _seconds("since_last_s", "Time since the frame before; empty for the first."),
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
        _seconds("time_s", "When; of a time-gap, when the program ran again."),
        _text("reason", "Why; empty where the event has no reason."),
        _seconds(
            "stood_still_s",
            "Of a time-gap: how long the program did not run, without the time the machine slept; else empty.",
        ),
        _seconds("suspended_s", "Of a time-gap: how long the machine slept; else empty."),
    ),
)
ANSWERS = Table(
    "answers",
    "an answer to a question, or to a statement of the consent.",
    (
        *_SESSION,
        Column(
            "origin", "text", "Who answered.", levels={name: _ORIGINS[name] for name in ("live", "simulated")}
        ),
        _integer("attempt", "Which attempt at the sitting, from 1."),
        _integer("timeline_step", "Which step of the sitting's timeline, from 1."),
        _text("questionnaire", "Name of the questionnaire; `consent` for statements of the consent."),
        _text("question", "Its id; the statement of a consent."),
        _text(
            "answer",
            "As it was given; several choices are joined by `; `. Empty: the participant preferred not to answer.",
        ),
        _number("answer_number", "The same where it is a number; else empty."),
        _boolean("passed", "Whether an attention check was passed; empty where the question is none."),
        _seconds("shown_s", "When the question came on screen, since the sitting began; empty for consent."),
        _seconds("answered_s", "When the answer was confirmed, since the sitting began."),
        _seconds("duration_s", "The time between both; empty for consent."),
    ),
)
TRIALS = Table(
    "trials",
    "a reaction-time trial, practice and catch trials included.",
    (
        _text("participant", "Code of the participant."),
        _text("session", "Name of the file, without its ending."),
        _text("task", "simple, choice, go/no-go, memory search, visual search, recognition or feedback lag."),
        Column(
            "domain",
            "text",
            "Game that was watched in the feedback-lag task; empty in other tasks.",
            levels={name: "" for name in GAMES},
        ),
        _integer("block", "Which block, from 1."),
        _integer("trial", "Which trial of the file, from 1."),
        _boolean("practice", "Whether it does not count."),
        _boolean("catch", "Whether nothing was shown: who presses there guesses."),
        _text("trial_condition", "What the trial tests, such as `go`, or `absent, set size 4`."),
        _text("stimulus", "What was shown, or the event that was waited for; empty in catch trials."),
        _text(
            "expected_keys", "Keys that answer rightly, joined by spaces; empty where withholding is right."
        ),
        _seconds("foreperiod_s", "Planned time from the trial's start to the stimulus."),
        _seconds("started_s", "When the foreperiod began, since the first trial of the file began."),
        _seconds(
            "onset_s",
            "When the stimulus's frame was handed to the terminal; in catch trials, when it would have been. Empty "
            "if it never was.",
        ),
        _text("key", "First allowed key at or after the onset; empty without one."),
        _seconds("rt_s", "Reaction time; empty without a key."),
        Column(
            "status",
            "text",
            "What came of it.",
            levels={
                "ok": "right answer, or rightly withheld",
                "anticipation": "faster than a reaction can be",
                "time-out": "no key in time: the reaction time is longer than `time_out_s`",
                "wrong key": "another allowed key",
                "repeat": "a held key's repeat",
            },
        ),
        _boolean("right_censored", "Whether `status` is time-out: the reaction time is known to be longer."),
        _integer("early_presses", "Allowed keys between start and onset.", "presses"),
        _integer("other_presses", "Other keys during the trial.", "presses"),
        _seconds(
            "frame_interval_s", "From the frame before to the onset's frame; empty where it is not known."
        ),
        _seconds("time_out_s", "Longest wait for a key."),
        _seconds("least_rt_s", "A faster key is an anticipation."),
        _text("comment", "Remark of the program, such as why a trial was abandoned; mostly empty."),
    ),
)
TABLES = (
    SESSIONS, SETTINGS, PLAYED, STEPS, PRESSES, CREDIT, FRAMES, INTERRUPTIONS, ANSWERS, TRIALS,
)  # fmt: skip
"""All tables, in the order of the codebook."""
