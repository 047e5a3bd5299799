"""What can happen in a session: frozen records that are sent between processes, recorded, and compared by
replay.

Two ordered streams make a session. *Inputs* come from the screen and the participant; *outputs* come from the
domain and the agent. Each output says how many inputs had been taken in before it, so that a replay can act
on every input at exactly the same point.

All times are integer nanoseconds of one monotonic clock (`core.numerics.clock`).
"""

from typing import Literal, Self

import msgspec

CoverReason = Literal["pause", "help", "quit-dialogue", "resize", "gap", "count-down", "question"]
"""What lay over the game on screen."""
Verdict = Literal["accepted", "other", "repeat", "no-presses-left", "covered", "not-playing"]
"""What became of a press: only accepted ones are learned from."""


class Record(
    msgspec.Struct,
    frozen=True,
    tag_field="type",
    kw_only=True,
    forbid_unknown_fields=True,
    omit_defaults=True,
):
    """Base of everything that is written to a recording: the field `type` names the class."""


class ActionRecord(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What was done at a step, in a game's own words: the base of one struct per game.

    Each game declares its fields: whole numbers, in the order in which recordings hold them; `UNSET` where an
    imported recording does not say. `core.plugins.GamePlugin.action` names the struct. A recording holds the
    fields alone (`StepTaken.detail`), so the game of its header says which struct they are.
    """

    @classmethod
    def of(cls, step: "StepTaken") -> Self:
        """Return the action of a step of this game.

        Raises:
            ValueError: the step is of another game; the message says what came and what was expected.
        """
        try:
            return msgspec.convert(step.detail, cls)
        except msgspec.ValidationError as error:
            raise ValueError(
                f"step {step.step} was {step.detail}, expected {', '.join(cls.__struct_fields__)}: {error}"
            ) from error

    def plain(self) -> dict[str, int]:
        """Return the fields that are set, by name, as `StepTaken.detail` holds them."""
        fields: dict[str, int] = msgspec.to_builtins(self)
        return fields


# --- inputs: what the screen showed and what the participant did --------------------------------------------


class FrameShown(Record, frozen=True, kw_only=True, tag="frame-shown"):
    """A frame with new content has left for the terminal."""

    frame: int
    """Number of the frame in this session, from 0."""
    step: int
    """Watched step on screen (see `StepTaken.step`); -1 when no step is (between episodes)."""
    flushed_ns: int
    """When the frame's last byte was handed to the terminal."""


class ScreenCleared(Record, frozen=True, kw_only=True, tag="screen-cleared"):
    """The step on screen was covered: a pause, a help page, a dialogue."""

    time_ns: int
    reason: CoverReason
    """`gap`: the session paused by itself after a `TimeGap`. `count-down`: a game is about to begin or to go
    on; the participant sees a number in its place. `question`: the agent poses a question (`QuestionPosed`);
    no later press is credited to what was on screen before."""


class KeyPressed(Record, frozen=True, kw_only=True, tag="key-pressed"):
    """One key press, raw. Also the presses that nobody learns from, with the reason."""

    press: int
    """Number of the press in this session, from 0."""
    time_ns: int
    """When the terminal's bytes were read (not when a handler ran)."""
    key: str
    """Name of the key as the terminal reports it."""
    value: float | None
    """Feedback meant by the key: > 0 good, < 0 bad, 0 neither (graded feedback); None for any other key."""
    frame: int
    """Frame on screen at `time_ns`; -1 before the first."""
    step: int
    """Watched step on screen at `time_ns`; -1 when there was none."""
    verdict: Verdict
    """Only accepted presses are learned from; the rest say why not."""
    asked_wrong: bool = False
    """The participant had been asked to press the wrong key deliberately."""
    source: Literal["participant", "simulated"] = "participant"
    person: int = 0
    """Who pressed, where several do: the first of the protocol's people is 0, the others are 1, 2, ...; -1 is
    a key of none of them. In simulated sessions without people the trainer is 0, its others are 1, 2, ..."""
    read_as: str = ""
    """The letter that stands on this key in the Latin layout, where `key` is of another one; "" where it is
    not."""
    layout: str = ""
    """The layout by which `read_as` was found (`core.feedback.layouts`); "" where `key` is a Latin letter or
    unknown."""


class PressRetracted(Record, frozen=True, kw_only=True, tag="press-retracted"):
    """An accepted press does not count after all."""

    press: int
    time_ns: int
    reason: Literal["participant", "auto-repeat"]
    """`auto-repeat`: a held key was recognised, and this press had opened the run."""


class WrongPressAsked(Record, frozen=True, kw_only=True, tag="wrong-press-asked"):
    """The protocol asked the participant for one deliberately wrong press (the paper: about 1 in 10)."""

    time_ns: int
    step: int


class QuestionAnswered(Record, frozen=True, kw_only=True, tag="question-answered"):
    """A question of the agent is over: an option was chosen, none was wanted, or time was up."""

    question: int
    """Number of the question (`QuestionPosed`)."""
    shown_ns: int
    """When the options had been handed to the terminal; of several times, because a page lay over them, the
    last one. `time_ns - shown_ns` is the latency of the answer."""
    time_ns: int
    """Of a key the time of its press (`KeyPressed.time_ns`); otherwise when the time was up."""
    answer: Literal["chosen", "none", "time-limit"]
    chosen: int = -1
    """Action that was chosen, one of `QuestionPosed.options`; -1 where none was."""
    press: int = -1
    """The key press that gave the answer; -1 where time was up."""
    person: int = 0
    """Who answered, as in `KeyPressed.person`."""


class Resumed(Record, frozen=True, kw_only=True, tag="resumed"):
    """The participant came back from a pause, a help page or a dialogue."""

    time_ns: int


class TimeGap(Record, frozen=True, kw_only=True, tag="time-gap"):
    """The program did not run for more than a second: the machine slept, or the process was stopped.

    No press after the gap is credited to what was on screen before it. Version 2 of the format.
    """

    last_ns: int
    """When the program was last known to run; `time_ns` or earlier."""
    time_ns: int
    """When it ran again."""
    suspended_ns: int = 0
    """How long the machine was suspended: this clock does not count that time on Linux. >= 0."""
    joint: bool = False
    """The session was broken off, and goes on here in another file: first event of a resumed session."""


class FocusLost(Record, frozen=True, kw_only=True, tag="focus-lost"):
    """The terminal's window no longer receives keys. Only terminals that report it. Version 2 of the
    format.
    """

    time_ns: int


class FocusRegained(Record, frozen=True, kw_only=True, tag="focus-regained"):
    """The terminal's window receives keys again. Only terminals that report it. Version 2 of the format."""

    time_ns: int


StopReason = Literal[
    "participant", "window-closed", "signal", "worker-died", "time-limit", "disk-failed", "practised"
]
"""Why a session ends before its last game.

`participant`: by a key. `window-closed`: the terminal went away (SIGHUP, or its end of the line closed).
`signal`: the process was asked to end (SIGTERM). `worker-died`: the learner failed or did not answer.
`time-limit`: the protocol's time was over. `disk-failed`: the recording could not be written any more.
`practised`: in a practice, both keys had been pressed in time.

Version 1 knows participant, worker-died and time-limit only: there, "participant" may also be a closed
window, a signal or a full disk.
"""


class StopAsked(Record, frozen=True, kw_only=True, tag="stop-asked"):
    """The session is to end: the episode on screen is truncated."""

    time_ns: int
    reason: StopReason


Input = (
    FrameShown
    | ScreenCleared
    | KeyPressed
    | PressRetracted
    | WrongPressAsked
    | QuestionAnswered
    | Resumed
    | TimeGap
    | FocusLost
    | FocusRegained
    | StopAsked
)


# --- outputs: what the domain and the agent did -------------------------------------------------------------


class EpisodeStarted(Record, frozen=True, kw_only=True, tag="episode-started", rename={"handover": "share"}):
    """A watched episode begins."""

    episode: int
    """Number of the episode in this session, watched or not, from 0."""
    time_ns: int
    inputs: int
    """How many inputs had been taken in before."""
    episode_seed: int
    policy: int
    """Which of the environment learner's policies is played."""
    form: int
    """How R and H are combined in this episode (a form of `core.combination.config`); -1 in imported ones."""
    w_r: float
    """Weight of the environment's values in this episode."""
    trust: float | None
    """What the rule of trust said of the participant when the episode began (Eq. 4, 5); None: version 1 did
    not record it."""
    weight: float
    """Weight w_h of the participant's values that the scheme used in this episode; some do not go by
    trust."""
    handover: float
    """Probability of handing the choice to the human policy in this episode (control sharing), else 0."""
    shaping: float = 0.0
    """Added to the reward of a step per unit of H in this episode (reward shaping), else 0."""
    augmentation: float = 0.0
    """Weight of H in what the learner learns (Q augmentation), else 0."""


class StepTaken(Record, frozen=True, kw_only=True, tag="step-taken"):
    """The agent has decided one step of a watched episode; the step is now shown."""

    episode: int
    step: int
    """Number of the watched step in this session, from 0: never starts again within a session."""
    time_ns: int
    inputs: int
    action: int
    """Index of the chosen action among the choices of the state."""
    environment_action: int
    """What the environment policy alone would have chosen."""
    human_action: int
    """What the human policy alone would have chosen; -1 while there is no human policy."""
    detail: dict[str, int]
    """The action in the game's words (Tetris: piece, orientation, column), as a table: which one, says the
    game's own `ActionRecord`, and `ActionRecord.of` reads it."""
    reward: float
    state: list[float] | None = None
    """What the decision was taken on, where only a simulator could tell again (Keepaway: the state variables
    of the keeper who decided, in the order of `feature_names`): a recording can be learned from whatever
    becomes of the simulator."""
    observed: dict[str, list[int]] | None = None
    """State before and after, in the domain's numbers: only in imported recordings, which cannot be
    re-run."""


class QuestionPosed(Record, frozen=True, kw_only=True, tag="question-posed"):
    """The agent asks which of some actions the participant would take (`core.combination.asking`).

    The game stands still until the question is over. The decision that was asked about is the next
    `StepTaken`; the agent is free to decide otherwise than the answer.
    """

    question: int
    """Number of the question in this session, from 0."""
    episode: int
    step: int
    """Number that the decision's step will have."""
    time_ns: int
    inputs: int
    """How many inputs had been taken in before."""
    options: list[int]
    """Two or three actions, as in `StepTaken.action`; the first has the first key."""
    details: list[dict[str, int]]
    """Each option in the domain's words, as in `StepTaken.detail`."""
    disagreement: float
    """How unsure the agent was, in [0, 1] (`core.combination.asking.Question`)."""


class EpisodeEnded(Record, frozen=True, kw_only=True, tag="episode-ended"):
    """A watched episode is over."""

    episode: int
    time_ns: int
    inputs: int
    performance: float
    """The domain's performance measure pm (Tetris: lines cleared)."""
    steps: int
    ended: Literal["termination", "truncation"]
    agreed: int
    """Steps at which environment and human policy chose the same action."""
    agreed_worst: int
    """Steps at which the environment policy chose the human policy's worst action."""
    trust: float
    """What the rule of trust says of the participant after this episode (of several people: the mean)."""
    digest: str
    """Fingerprint of everything the agent has learned (hex)."""
    time: int | None = None
    """The domain's own time at the end (`core.domain.Domain.time`); None in older files, which did not record
    it."""


class UnseenPlayed(Record, frozen=True, kw_only=True, tag="unseen-played"):
    """Episodes played without a screen, between two watched ones."""

    first_episode: int
    time_ns: int
    inputs: int
    policies: list[int]
    performances: list[float]
    steps: list[int]
    agreed: list[int]
    agreed_worst: list[int]
    trust: float
    """What the rule of trust says of the participant after the last of them (of several people: the mean)."""
    weights: list[float] | None
    """Weight w_h that the scheme used in each of them; None where version 1 did not record it."""
    digest: str


class CreditGiven(Record, frozen=True, kw_only=True, tag="credit-given"):
    """How one accepted press was shared out among the steps: what adds up to 1 with what fell outside."""

    press: int
    steps: list[int]
    shares: list[float]
    before_first: float
    """Mass that fell before the first watched step."""
    in_gaps: float
    """Mass that fell into pauses, between episodes, and on what was on screen before a `TimeGap`."""
    too_late: float = 0.0
    """Mass of steps whose sample had been given out already (aggregate credit, a press reported very
    late)."""
    merged_into: int | None = None
    """The press that opened the burst of which this one is part; such a press has no mass of its own."""


class SessionEnded(Record, frozen=True, kw_only=True, tag="session-ended"):
    """The agent's last word: all that it has learned."""

    time_ns: int
    inputs: int
    reason: str
    weights: dict[str, list[float]]
    """The agent's weight vectors by name."""
    digest: str


Output = EpisodeStarted | StepTaken | QuestionPosed | EpisodeEnded | UnseenPlayed | CreditGiven | SessionEnded
Event = Input | Output
