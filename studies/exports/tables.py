"""The tidy tables: every column with its unit, its levels and its meaning. The codebook is made from them."""

from studies.exports.columns import Column, Table
from studies.exports.event_tables import CREDIT, FRAMES, INTERRUPTIONS, PRESSES, QUESTIONS, STEPS
from studies.exports.shared_columns import (
    KEYS,
    ORIGINS,
    WHOSE,
    boolean,
    integer,
    number,
    seconds,
    text,
)
from studies.exports.words import GAMES

SESSIONS = Table(
    "sessions",
    "a recorded session.",
    (
        *KEYS,
        text("created_utc", "Wall-clock time of the start, ISO 8601; a remark in anonymised files."),
        seconds("duration_s", "From the start to the last recorded time."),
        text(
            "ended",
            "How it ended: finished, participant, window-closed, signal, worker-died, time-limit, "
            "disk-failed, running (it is being recorded now), killed, cut, closed or imported (see "
            "`arl recordings`).",
        ),
        integer("games_planned", "Watched games of the protocol; empty in imported logs.", "games"),
        integer("games_begun", "Watched games that began.", "games"),
        integer("games_finished", "Watched games that were not broken off by the session's end.", "games"),
        integer("games_unseen", "Games that were played without a screen.", "games"),
        integer("steps", "Watched steps.", "steps"),
        integer("presses_counted", "Presses that were accepted and not taken back.", "presses"),
        integer("presses_retracted", "Accepted presses that were taken back.", "presses"),
        text("protocol", "Name of the protocol."),
        text("learner", "Type of the environment's learner."),
        text("scheme", "How R and H are combined."),
        text("trust_rule", "Rule of trust in the participant."),
        text("human_model", "Type of the human reward model."),
        text("credit_rule", "How a press is credited to steps, with its numbers."),
        text("credit_scheme", "Whether each press is a sample, or each step."),
        text("key_good", "Key that praises."),
        text("key_bad", "Key that blames."),
        integer("max_presses_per_game", "Presses accepted in a game.", "presses"),
        Column("root_seed", "text", "Root seed of the session: a whole number of up to 19 digits."),
        integer("format_version", "Version of the recording's format in which the session was recorded."),
        text(
            "program_version", "Version of the program that recorded it; empty where the file does not say."
        ),
    ),
)
SETTINGS = Table(
    "settings",
    "a setting of a session's protocol, defaults written out.",
    (
        *WHOSE,
        text("setting", "Path of the setting in the protocol, such as `agent.credit.delay.shape`."),
        text("value", "Its value, as JSON."),
    ),
)
PLAYED = Table(
    "games",
    "a game, watched or played without a screen.",
    (
        *KEYS,
        integer("game", "Which watched game of the session, from 1; empty for unseen ones."),
        boolean("watched", "Whether it was on screen."),
        integer(
            "episode_index", "Number of the game among watched and unseen ones, from 0, as in the recording."
        ),
        integer("policy_index", "Which of the learner's policies played, from 0."),
        number(
            "performance",
            "Tetris: lines cleared. Keepaway: seconds the ball was kept. Empty where the session "
            "ended before the game did.",
        ),
        text("performance_unit", "Unit of `performance`.", lines="", s="seconds"),
        integer("steps", "Steps of the game.", "steps"),
        text(
            "ended",
            "Why it ended; empty where the session ended before it did.",
            termination="by the rules of the game",
            truncation="after the most steps, or by the session's end",
        ),
        seconds("started_s", "When it began; empty for unseen games."),
        seconds("ended_s", "When its last step was over; empty for unseen games."),
        seconds("duration_s", "From its beginning to its end; empty for unseen games."),
        number(
            "trust_before",
            "What the rule of trust said of the participant when it began; empty for unseen games and where "
            "version 1 did not record it.",
        ),
        number(
            "trust_after",
            "What the rule of trust said after it; of unseen games after the last of their group.",
        ),
        number(
            "weight",
            "Weight w_h of the participant's values that the scheme used; empty where version 1 did not "
            "record it.",
        ),
        number("environment_weight", "Weight w_r of the environment's values; empty for unseen games."),
        number(
            "handover",
            "Probability of handing the choice to the human policy (control sharing), else 0; empty for "
            "unseen games.",
        ),
        number(
            "shaping", "Added to the reward per unit of H (reward shaping), else 0; empty for unseen games."
        ),
        number(
            "augmentation",
            "Weight of H in what the learner learns (Q augmentation), else 0; empty for unseen games.",
        ),
        integer("agreed", "Steps at which environment and human policy chose the same.", "steps"),
        integer(
            "agreed_worst",
            "Steps at which the environment policy chose the human policy's worst action.",
            "steps",
        ),
        integer("presses_counted", "Presses made in it that were accepted and not taken back.", "presses"),
        integer("presses_good", "Of these, praise.", "presses"),
        integer("presses_bad", "Of these, blame.", "presses"),
        integer("presses_neither", "Of these, neither (graded feedback).", "presses"),
    ),
)
ANSWERS = Table(
    "answers",
    "an answer to a question, or to a statement of the consent.",
    (
        *WHOSE,
        Column(
            "origin", "text", "Who answered.", levels={name: ORIGINS[name] for name in ("live", "simulated")}
        ),
        integer("attempt", "Which attempt at the sitting, from 1."),
        integer("timeline_step", "Which step of the sitting's timeline, from 1."),
        text("questionnaire", "Name of the questionnaire; `consent` for statements of the consent."),
        text("question", "Its id; the statement of a consent."),
        text(
            "answer",
            "As it was given; several choices are joined by `; `. Empty: the participant preferred not to "
            "answer.",
        ),
        number("answer_number", "The same where it is a number; else empty."),
        boolean("passed", "Whether an attention check was passed; empty where the question is none."),
        seconds("shown_s", "When the question came on screen, since the sitting began; empty for consent."),
        seconds("answered_s", "When the answer was confirmed, since the sitting began."),
        seconds("duration_s", "The time between both; empty for consent."),
    ),
)
TRIALS = Table(
    "trials",
    "a reaction-time trial, practice and catch trials included.",
    (
        text("participant", "Code of the participant."),
        text("session", "Name of the file, without its ending."),
        Column(
            "origin", "text", "Who pressed.", levels={name: ORIGINS[name] for name in ("live", "simulated")}
        ),
        text("task", "simple, choice, go/no-go, memory search, visual search, recognition or feedback lag."),
        Column(
            "domain",
            "text",
            "Game that was watched in the feedback-lag task; empty in other tasks.",
            levels={name: "" for name in GAMES},
        ),
        integer("block", "Which block, from 1."),
        integer("trial", "Which trial of the file, from 1."),
        boolean("practice", "Whether it does not count."),
        boolean("catch", "Whether nothing was shown: who presses there guesses."),
        text("trial_condition", "What the trial tests, such as `go`, or `absent, set size 4`."),
        text("stimulus", "What was shown, or the event that was waited for; empty in catch trials."),
        text(
            "expected_keys", "Keys that answer rightly, joined by spaces; empty where withholding is right."
        ),
        seconds("foreperiod_s", "Planned time from the trial's start to the stimulus."),
        seconds("started_s", "When the foreperiod began, since the first trial of the file began."),
        seconds(
            "onset_s",
            "When the stimulus's frame was handed to the terminal; in catch trials, when it would have been. "
            "Empty if it never was.",
        ),
        text("key", "First allowed key at or after the onset; empty without one."),
        seconds("rt_s", "Reaction time; empty without a key."),
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
        boolean("right_censored", "Whether `status` is time-out: the reaction time is known to be longer."),
        integer("early_presses", "Allowed keys between start and onset.", "presses"),
        integer("other_presses", "Other keys during the trial.", "presses"),
        seconds(
            "frame_interval_s", "From the frame before to the onset's frame; empty where it is not known."
        ),
        seconds("time_out_s", "Longest wait for a key."),
        seconds("least_rt_s", "A faster key is an anticipation."),
        text("comment", "Remark of the program, such as why a trial was abandoned; mostly empty."),
    ),
)
TABLES = (
    SESSIONS, SETTINGS, PLAYED, STEPS, PRESSES, CREDIT, FRAMES, INTERRUPTIONS, QUESTIONS, ANSWERS, TRIALS,
)  # fmt: skip
"""All tables, in the order of the codebook."""
