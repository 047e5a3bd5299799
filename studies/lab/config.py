"""What a study consists of, as in `study.toml`: sittings, steps, conditions, and the rules of assignment.

Nothing here shows a page or reads a clock. Texts are files in Markdown beside the study file.
"""

from typing import Annotated, Any, Literal

import msgspec
from msgspec import Meta

from core.configuration.fields import ALLOWED
from core.session.protocol import Language

Hours = Annotated[float, Meta(ge=0.0, le=24.0 * 366)]
PressesPerGame = Annotated[float, Meta(ge=0.0, le=1_000_000.0)] | None
Seconds = Annotated[float, Meta(ge=0.0, le=3600.0)]
Text = Annotated[str, Meta(pattern=r"\S", extra={ALLOWED: "not empty"})]
"""Name of a Markdown file beside the study file."""
Code = Annotated[
    str,
    Meta(
        pattern=r"^[A-Za-z0-9][A-Za-z0-9_-]{0,31}$",
        extra={ALLOWED: "1 to 32 letters, digits, '-' or '_', beginning with a letter or a digit"},
    ),
]
"""A pseudonym or a name of a condition: up to 32 letters, digits, '-' or '_'."""

ASSIGNED = "assigned"
"""The condition of a block that the participant's order decides."""


class Table(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Base of all tables of a study file: an unknown key is refused."""


# --- steps --------------------------------------------------------------------------------------------------


class Consent(Table, frozen=True, kw_only=True, tag="consent"):
    """Asks for consent. Declining ends the study, and leaves nothing but a count."""

    text: Text
    """Name of a Markdown file beside the study file."""
    statements: tuple[str, ...] = ("I have read the information and agree to take part.",)
    """Each one must be agreed to."""
    optional: tuple[str, ...] = ()
    """Statements that may be declined; the answers are recorded."""
    version: str = "1"
    """Version of the text, for the record of consent."""

    def __post_init__(self) -> None:
        if not self.statements:
            raise ValueError("statements holds at least one sentence to agree to")


class TextPage(Table, frozen=True, kw_only=True, tag="page"):
    """Shows a text until the participant goes on."""

    text: Text
    """Name of a Markdown file beside the study file."""


class Practice(Table, frozen=True, kw_only=True, tag="practice"):
    """Games that are recorded, but do not count: they are played slowly, and each press is explained."""

    games: Annotated[int, Meta(ge=1, le=20)] = 2
    """How many games at most."""


class Calibration(Table, frozen=True, kw_only=True, tag="calibration"):
    """Measures how long the participant takes to react and to judge (`arl calibrate`)."""

    tasks: tuple[str, ...] = ("feedback-lag",)
    """Tasks of `arl calibrate`: simple, choice, go-no-go, memory-search, visual-search, recognition,
    feedback-lag."""
    trials: Annotated[int, Meta(ge=1, le=1000)] = 40
    """Scored trials per task."""
    practice: Annotated[int, Meta(ge=0, le=100)] = 8
    """Practice trials per task."""

    def __post_init__(self) -> None:
        if not self.tasks:
            raise ValueError("tasks names at least one task of `arl calibrate`")


class Block(Table, frozen=True, kw_only=True, tag="block"):
    """A session: the participant judges an agent in one condition."""

    condition: str = ASSIGNED
    """Name of a condition; "assigned" takes the next one of the participant's order."""
    games: Annotated[int, Meta(ge=1, le=1000)] | None = None
    """Watched games; by default those of the protocol."""


class Break(Table, frozen=True, kw_only=True, tag="break"):
    """A rest: the participant goes on when they are ready."""

    shortest_s: Seconds = 0.0
    """The participant cannot go on before."""
    longest_s: Seconds = 300.0
    """The participant is asked to come back after this time; the study waits all the same."""
    text: str = ""
    """A Markdown file; a short text of ours where it is empty."""

    def __post_init__(self) -> None:
        if self.longest_s < self.shortest_s:
            raise ValueError(
                f"longest_s is at least shortest_s, {self.shortest_s:g} s, got {self.longest_s:g} s"
            )


class Questionnaire(Table, frozen=True, kw_only=True, tag="questionnaire"):
    """Asks questions; the answers are recorded with their times."""

    questions: Text
    """A TOML file beside the study file, or a ready one: demographics, nasa-tlx, sus, trust, taught."""


class Debriefing(Table, frozen=True, kw_only=True, tag="debriefing"):
    """Thanks, the study's background, and the participant's own numbers."""

    text: Text
    """Name of a Markdown file beside the study file."""
    own_numbers: bool = True
    """Show games, presses, and how the agent played at the beginning and at the end."""
    show_condition: bool = False
    """Name the conditions in the participant's own order."""


Step = Consent | TextPage | Practice | Calibration | Block | Break | Questionnaire | Debriefing


def kind_of(step: Step) -> str:
    """Return the step's `type` in the file."""
    return str(step.__struct_config__.tag)


# --- sittings and assignment --------------------------------------------------------------------------------


class Sitting(Table, frozen=True, kw_only=True):
    """What a participant does in one visit."""

    name: str
    """What the experimenter calls it: "day 1"."""
    steps: tuple[Step, ...]
    after_hours: Hours = 0.0
    """Shortest time since the end of the sitting before."""
    within_hours: Hours | None = None
    """Longest time since the end of the sitting before; None: no limit."""

    def __post_init__(self) -> None:
        if not self.steps:
            raise ValueError(f"the sitting {self.name!r} has no steps: add [[sittings.steps]]")
        if self.within_hours is not None and self.within_hours < self.after_hours:
            raise ValueError(
                f"within_hours is at least after_hours, {self.after_hours:g} h, got {self.within_hours:g} h"
            )


class LatinSquare(Table, frozen=True, kw_only=True, tag="latin-square"):
    """Every participant meets all conditions, in an order of a balanced Latin square (Williams 1949).

    Each condition comes at each position equally often, and follows each other condition equally often. n
    conditions need n orders where n is even, else 2 n. Where the timeline has n, 2 n, 3 n ... blocks, a
    participant goes through the conditions so often, each time in the next order of the square.
    """


class PermutedBlocks(Table, frozen=True, kw_only=True, tag="permuted-blocks"):
    """Every participant meets one condition, in all blocks; in each group of participants every condition
    comes equally often.
    """

    each: Annotated[int, Meta(ge=1, le=100)] = 1
    """How often each condition comes in one group of participants."""


class Listed(Table, frozen=True, kw_only=True, tag="list"):
    """Orders as they are written down, one per participant, from the beginning again after the last one."""

    orders: tuple[tuple[str, ...], ...]
    """Each order names one condition per assigned block, or one for all of them."""

    def __post_init__(self) -> None:
        if not self.orders or not all(self.orders):
            raise ValueError("orders holds at least one order, and each order names at least one condition")


Assignment = LatinSquare | PermutedBlocks | Listed


class Dropouts(Table, frozen=True, kw_only=True):
    """When a participant counts as dropped out, and whether another participant gets their place."""

    after_hours: Hours = 24.0 * 14
    """Unfinished, and without a sign of life for so long."""
    replace: bool = True
    """Their place is given to the next participant."""
    replace_withdrawn: bool = True
    """The place of a participant who withdrew is given to the next one, too."""


class Resuming(Table, frozen=True, kw_only=True):
    """What happens to a sitting that broke off."""

    rule: Literal["resume", "restart", "refuse"] = "resume"
    """resume: go on after the last finished game. restart: the sitting begins anew; what was recorded is
    kept. refuse: the experimenter decides, by `arl study run --broken-off`.
    """
    within_hours: Hours = 4.0
    """An older sitting is neither resumed nor restarted by rule: the experimenter decides, by `arl study run
    --broken-off`."""


class Codes(Table, frozen=True, kw_only=True):
    """Pseudonyms that `arl study run` draws for participants who bring none."""

    prefix: Annotated[str, Meta(pattern=r"^[A-Za-z]{0,8}$", extra={ALLOWED: "at most 8 letters"})] = "P"
    """How each code begins."""
    length: Annotated[int, Meta(ge=3, le=12)] = 4
    """Letters and digits after the prefix; without 0, O, 1, I and L."""


class Simulated(Table, frozen=True, kw_only=True):
    """How often simulated participants press (`arl study simulate`), of all kinds and of each kind."""

    presses_per_game: PressesPerGame = None
    """Judgements in a watched game on average, of every kind without a number of its own. None: two fifths of
    [keys] max_presses_per_episode, as the paper's participants (section 4: 2 of 5)."""
    expert: PressesPerGame = None
    """The same of this kind, which judges as a controller far better than the learner."""
    lay: PressesPerGame = None
    """The same of this kind, which judges by what meets the eye."""
    myopic: PressesPerGame = None
    """The same of this kind, which judges the step's immediate effect."""
    hesitant: PressesPerGame = None
    """The same of this kind, which says nothing where it is hard to tell."""
    noisy: PressesPerGame = None
    """The same of this kind, which presses the wrong key in 3 of 10 cases."""
    useless: PressesPerGame = None
    """The same of this kind, which presses any key."""
    adversary: PressesPerGame = None
    """The same of this kind, which means the opposite."""
    instructed: PressesPerGame = None
    """The same of this kind, which makes no mistakes but those that it is asked for."""
    bursty: PressesPerGame = None
    """The same of this kind, which presses several times in a row; a burst counts once here."""
    hasty: PressesPerGame = None
    """The same of this kind, which presses before the outcome is seen, in a third of the cases."""
    slow: PressesPerGame = None
    """The same of this kind, which takes twice as long to press."""
    tiring: PressesPerGame = None
    """The same of this kind, which presses half as often after each 150 watched games."""
    leaves: PressesPerGame = None
    """The same of this kind, which says nothing any more after 300 watched games."""


class Study(Table, frozen=True, kw_only=True):
    """A study, completely."""

    format: Literal["arl-study"] = "arl-study"
    """Says that the file is a study."""
    name: Code
    """Names the folder of the study's data. Participants do not see it."""
    title: str = ""
    """What participants see above the pages."""
    language: Language = "en"
    """Of every word that is not the study's own: keys, questions whether to stop, ready questionnaires. The
    study's texts are in the language in which they are written. LANG does not change it."""
    version: str = "1"
    """Of the study, for the records; change it with the study."""
    seed: Annotated[int, Meta(ge=0, le=2**63 - 1)]
    """Orders, codes and the seeds of all sessions follow from it."""
    participants: Annotated[int, Meta(ge=1, le=100_000)]
    """How many are to finish."""
    protocol: dict[str, Any] = {}
    """The base protocol: tables as in `arl protocol`."""
    protocol_file: str = ""
    """The base protocol as a file beside the study file, in place of [protocol]."""
    conditions: dict[Code, dict[str, Any]]
    """Name to differences from the base protocol."""
    assignment: Assignment
    sittings: tuple[Sitting, ...]
    dropouts: Dropouts = Dropouts()
    resuming: Resuming = Resuming()
    codes: Codes = Codes()
    simulated: Simulated = Simulated()

    def __post_init__(self) -> None:
        if not self.conditions:
            raise ValueError("conditions is empty: write [conditions.NAME] for each condition")
        if ASSIGNED in self.conditions:
            raise ValueError(
                f'no condition is called "{ASSIGNED}": blocks use that word for the next in order'
            )
        if not self.sittings:
            raise ValueError("a study has at least one sitting: add [[sittings]]")
        if self.protocol and self.protocol_file:
            raise ValueError("write either [protocol] or protocol_file, not both")
        self._check_names()
        self._check_consent()
        self._check_orders()

    @property
    def steps(self) -> tuple[tuple[int, int, Step], ...]:
        """Every step with the numbers of its sitting and of its place in it, from 0."""
        return tuple(
            (number, place, step)
            for number, sitting in enumerate(self.sittings)
            for place, step in enumerate(sitting.steps)
        )

    @property
    def assigned_blocks(self) -> int:
        """How many blocks take their condition from the participant's order."""
        return sum(isinstance(step, Block) and step.condition == ASSIGNED for _, _, step in self.steps)

    def _check_names(self) -> None:
        known = ", ".join(self.conditions)
        for sitting, place, step in self.steps:
            if (
                isinstance(step, Block)
                and step.condition != ASSIGNED
                and step.condition not in self.conditions
            ):
                raise ValueError(
                    f"step {place + 1} of sitting {sitting + 1}: the condition {step.condition!r} is not "
                    f"among {known}; write one of them, or {ASSIGNED!r}"
                )
        for order in self.assignment.orders if isinstance(self.assignment, Listed) else ():
            for name in order:
                if name not in self.conditions:
                    raise ValueError(f"assignment.orders names the condition {name!r}; known: {known}")

    def _check_consent(self) -> None:
        first = next((where for *where, step in self.steps if isinstance(step, Consent)), None)
        asked = [where for *where, step in self.steps if not isinstance(step, Consent | TextPage)]
        if asked and (first is None or first > min(asked)):
            sitting, place = min(asked)
            raise ValueError(
                f"step {place + 1} of sitting {sitting + 1} records something before consent was given: "
                "put a step of type consent before it"
            )

    def _check_orders(self) -> None:
        blocks = self.assigned_blocks
        if isinstance(self.assignment, LatinSquare):
            wanted, fits = f"a multiple of {len(self.conditions)}", blocks % len(self.conditions) == 0
        elif isinstance(self.assignment, PermutedBlocks):
            wanted, fits = "at least one", True
        else:
            lengths = {len(order) for order in self.assignment.orders}
            wanted, fits = " or ".join(map(str, sorted(lengths))), lengths <= {1, blocks}
        if blocks == 0 or not fits:
            raise ValueError(
                f"the timeline has {blocks} blocks with an assigned condition; this assignment needs "
                f"{wanted} (an order of one condition serves any number of blocks)"
            )
