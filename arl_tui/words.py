"""What participants are told of each game, in plain words."""

from dataclasses import dataclass

from arl_tui.language import bold_cap, later, tr, trn
from studies.reaction_time.protocol import NO, YES


@dataclass(frozen=True, slots=True)
class Words:
    """The words of one game in English, marked with `later`; they are translated when they are shown."""

    heading: str
    """Title of the first screen."""
    welcome: str
    """What will be watched, {games} of it, and what is to be judged; {practises} says what happens in
    between."""
    rules: str
    """What happens and what counts, for the help page; {task} and {about} stand for the fields below."""
    practises: str
    """What the computer does between two watched games, as a sentence and a space; left out where it does
    nothing."""
    performance: str
    """What is counted, as a label before figures."""
    units: tuple[str, str]
    """Unit of what is counted, for one and for several, marked with `later_n`."""
    steps: str
    """What the steps of a game are, in the plural."""
    step: str
    """The same for one."""
    task: str = ""
    """What the computer tries to do, as {task} in the welcome and in the rules: in the language in use, and
    in markup."""
    about: str = ""
    """More of it, as {about} in the rules: sentences, in the language in use and in markup."""
    question: str = later("What should the computer do now?")
    """What the agent asks when it offers options; at most 31 characters."""

    def told(self, performance: float) -> str:
        """Return a performance with its unit."""
        figure = f"{performance:.4g}"
        return f"{figure} {trn(*self.units, 1 if figure == '1' else 2)}"

    @property
    def unit(self) -> str:
        """The unit of several, in the language in use."""
        return trn(*self.units, 2)


@dataclass(frozen=True, slots=True)
class JudgingWords:
    """What participants are told of a game in the feedback-lag task, in English, in markup, marked with
    `later`. `{no}` and `{yes}` stand for the keys.
    """

    instruction: str
    """What is seen, and which key says what."""
    reminder: str
    """Which key says what, in two lines."""


def judging_text(text: str) -> str:
    """Return a text about the tasks of a calibration with its keys, in the language in use."""
    return tr(text, no=bold_cap(NO), yes=bold_cap(YES), space=bold_cap("space"))
