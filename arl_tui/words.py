"""What participants are told of each game, in plain words."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Words:
    """The words of one game."""

    heading: str
    """Title of the first screen."""
    welcome: str
    """What will be watched, {games} of it, and what is to be judged; {practises} says what happens in between."""
    rules: str
    """What happens and what counts, for the help page."""
    practises: str
    """What the computer does between two watched games, as a sentence and a space; left out where it does nothing."""
    performance: str
    """What is counted, as a label before figures."""
    units: tuple[str, str]
    """Unit of what is counted, for one and for several."""
    steps: str
    """What the steps of a game are, in the plural."""
    step: str
    """The same for one."""

    def told(self, performance: float) -> str:
        """Return a performance with its unit."""
        figure = f"{performance:.4g}"
        return f"{figure} {self.units[0] if figure == '1' else self.units[1]}"


TETRIS = Words(
    heading="Teach a computer to play Tetris",
    welcome=(
        "You will watch a computer play {games} of Tetris. It does not know yet how to play well. {practises}You can "
        "help it: tell it what you think of where it has just put a piece."
    ),
    rules=(
        "The computer drops one piece after another. Full rows disappear: the more, the better. A game ends "
        "when the pile reaches the top.\n\nTell it what you think of where the last piece came to rest:\n"
    ),
    practises="It practises on its own between games. ",
    performance="Lines cleared",
    units=("line", "lines"),
    steps="pieces",
    step="piece",
)
KEEPAWAY = Words(
    heading="Teach a team to keep the ball",
    welcome=(
        "You will watch {games} of Keepaway. The keepers ([b]K[/]) pass a ball among themselves, and the takers ([b]T[/]) "
        "want it. A game ends when a taker has it, or it leaves the square: the longer the keepers keep it, the better. "
        "They do not know yet how to play well. {practises}You can help them: say what you think of the last pass, or "
        "of holding the ball too long."
    ),
    rules=(
        "The keepers (K) pass the ball among themselves; the takers (T) want it. A game ends when a taker has the "
        "ball or it leaves the square: the longer the keepers keep it, the better. The player with the ball holds "
        "it or passes it.\n\nTell the team what you think of its last pass, or of holding the ball too long:\n"
    ),
    practises="They practise on their own between games. ",
    performance="Seconds the ball was kept",
    units=("second", "seconds"),
    steps="decisions",
    step="option",
)
_WORDS = {"tetris": TETRIS, "keepaway": KEEPAWAY}


def words_of(game: str) -> Words:
    """Return the words of a game by its name (`core.session.protocol.Protocol.game`)."""
    return _WORDS[game]
