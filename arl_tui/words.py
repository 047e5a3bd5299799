"""What participants are told of each game, in plain words."""

from dataclasses import dataclass

from studies.reaction_time.protocol import NO, YES


@dataclass(frozen=True, slots=True)
class Words:
    """The words of one game."""

    heading: str
    """Title of the first screen."""
    welcome: str
    """What will be watched, {games} of it, and what is to be judged; {practises} says what happens in
    between."""
    rules: str
    """What happens and what counts, for the help page."""
    practises: str
    """What the computer does between two watched games, as a sentence and a space; left out where it does
    nothing."""
    performance: str
    """What is counted, as a label before figures."""
    units: tuple[str, str]
    """Unit of what is counted, for one and for several."""
    steps: str
    """What the steps of a game are, in the plural."""
    step: str
    """The same for one."""
    question: str = "What should the computer do now?"
    """What the agent asks when it offers options; at most 31 characters."""

    def told(self, performance: float) -> str:
        """Return a performance with its unit."""
        figure = f"{performance:.4g}"
        return f"{figure} {self.units[0] if figure == '1' else self.units[1]}"


@dataclass(frozen=True, slots=True)
class JudgingWords:
    """What participants are told of a game in the feedback-lag task, in markup."""

    instruction: str
    """What is seen, and which key says what."""
    reminder: str
    """Which key says what, in two lines."""


_KEYS = {"space": "Space", NO: NO.upper(), YES: YES.upper()}


def cap(key: str) -> str:
    """Return a key as it is printed on the keyboard, in markup."""
    return f"[reverse b] {_KEYS.get(key, key)} [/]"
