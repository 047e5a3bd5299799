"""What the screen has confirmed, as the terminal saw it, beside what is in the file."""

import re

from core.events import EpisodeStarted, KeyPressed, PressRetracted
from core.recording.reader import Recording
from tests.e2e.terminal import Terminal

GAME = re.compile(r"Game (\d+)")
LEFT = re.compile(r"(\d+) of (\d+) presses left")


class Confirmed:
    """Follows the count of presses left through the games of a session."""

    def __init__(self) -> None:
        self.presses: dict[int, int] = {}
        """Game (from 1) to the most presses that the screen has said are counted."""
        self._game = 0

    def look(self, terminal: Terminal) -> int:
        """Read the screen; return how many presses of the present game are confirmed."""
        game, left = GAME.search(terminal.text), LEFT.search(terminal.text)
        if game is None or left is None:
            return 0
        if int(game[1]) != self._game:
            # The title changes with the count, but half a frame may have been read.
            self._game = int(game[1])
            return 0
        count = int(left[2]) - int(left[1])
        self.presses[self._game] = max(count, self.presses.get(self._game, 0))
        return count

    def missing_from(self, recording: Recording) -> dict[int, int]:
        """Return game to number of presses that were confirmed and are not in the file; empty where all
        are."""
        written = most_at_once(recording)
        return {
            game: count - written.get(game, 0)
            for game, count in self.presses.items()
            if count > written.get(game, 0)
        }


def accepted(recording: Recording) -> dict[int, int]:
    """Return game (from 1) to its presses in the file that count in the end: accepted, and not taken back."""
    return {game: counts[-1] for game, counts in _counts(recording).items()}


def most_at_once(recording: Recording) -> dict[int, int]:
    """Return game (from 1) to the most presses that counted at any time: one that was taken back did count
    before."""
    return {game: max(counts) for game, counts in _counts(recording).items()}


def _counts(recording: Recording) -> dict[int, list[int]]:
    game, counts, game_of_press = 0, dict[int, list[int]](), dict[int, int]()
    for event in recording.events:
        match event:
            case EpisodeStarted():
                game += 1
                counts[game] = [0]
            case KeyPressed(verdict="accepted"):
                counts[game].append(counts[game][-1] + 1)
                game_of_press[event.press] = game
            case PressRetracted():
                of_press = counts[game_of_press[event.press]]
                of_press.append(of_press[-1] - 1)
    return counts
