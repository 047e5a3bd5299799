"""What the viewer knows of a recording: rules of credit, decisions of its agent and of a what-if, tags."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray

from arl_tui.games.registry import words_of
from arl_tui.viewer.workers import WholeIndex, Working
from core.feedback.credit import CurrentStep, Delay, PreviousStep, describe
from core.keepaway.action import ChosenOption
from core.keepaway.pitch import KeepawayConfig
from core.session.protocol import Protocol
from core.tetris.action import PlacedPiece
from core.tetris.config import TetrisConfig
from core.tetris.game import Board, FallingPiece, landing_row
from studies.session_view.credit_strip import PAPER, UNIFORM, CreditStrip, strip_of
from studies.session_view.session import Press, SessionView
from studies.session_view.tags import Tags, write_tags_csv
from studies.session_view.thoughts import Thought, Thoughts

HOLD = 0
NO_TIMES: NDArray[np.int64] = np.zeros(0, dtype=np.int64)


@dataclass(frozen=True, slots=True)
class Rule:
    """A credit rule that the strip can show."""

    words: str
    delay: Delay
    recorded: bool = False
    """The shares are those that the session itself gave."""


def rules_of(session: SessionView, own: Delay | None = None) -> tuple[Rule, ...]:
    """Return the rules that can be switched through, the session's own first.

    Args:
        session: the recording.
        own: the participant's measured delay, if there is one.
    """
    rules = []
    if session.protocol is not None:
        delay = session.protocol.agent.credit.delay
        credited = len(session.index.tables["credits"]) > 0
        rules.append(Rule(f"as recorded: {describe(delay)}", delay, recorded=True) if credited else
                     Rule(f"the protocol's: {describe(delay)}", delay))  # fmt: skip
    if own is not None:
        rules.append(Rule(f"own delay: {describe(own)}", own))
    for words, delay in (
        ("paper", PAPER),
        ("uniform", UNIFORM),
        ("previous", PreviousStep()),
        ("current", CurrentStep()),
    ):
        text = describe(delay)
        rules.append(Rule(words if text == words else f"{words}: {text}", delay))
    return tuple(rules)


class Viewing:
    """A recording on the screen, and what has been worked out about it."""

    def __init__(
        self,
        path: Path,
        session: SessionView,
        tags: Tags,
        *,
        rules: Sequence[Rule],
        own: Working,
        begin_what_if: Callable[[Protocol], Working],
        what_if: tuple[str, Protocol] | None = None,
        whole: WholeIndex | None = None,
    ) -> None:
        """Prepare.

        Args:
            path: of the recording as it was named.
            session: opened.
            tags: of the recording.
            rules: from `rules_of`.
            own: decisions of the session's agent.
            begin_what_if: begins to work out what another protocol's agent thinks.
            what_if: name and protocol that the command asked for; begun at once.
            whole: the index that is being built, where `session` is the first part of a long recording.
        """
        self.path = path
        self.session = session
        self.tags = tags
        self.rules = tuple(rules)
        self.other: Working | None = None
        self.other_name = ""
        self.whole = whole
        self._rule = 0
        self._own = own
        self._begin = begin_what_if
        self._asked = what_if
        self._differences: tuple[int, NDArray[np.int64]] = (0, NO_TIMES)
        self._strip = lru_cache(maxsize=64)(self._strip_of)
        self._candidates = lru_cache(maxsize=8)(self._candidates_of)
        self.warm = False
        """Whether compiled code has been loaded; see `warm_up`."""
        self.drawn_receivers: Callable[[], tuple[int, tuple[int, ...]]] = lambda: (-1, ())
        """Returns the row of the step drawn last, and to whom its options pass; set by what draws the
        pitch."""
        if what_if is not None:
            self.toggle_what_if()

    @property
    def state(self) -> tuple[object, ...]:
        """Changes whenever something that is drawn has changed, apart from the time."""
        other = None if self.other is None else (self.other.words, len(self.other.thoughts))
        return self.warm, self._rule, self._own.words, other, len(self.tags.all), self.other_name

    def look_again(self) -> None:
        """Forget what was worked out of the first part of a recording: the whole one is there."""
        self._strip.cache_clear()
        self._candidates.cache_clear()
        self._board = -1, ()
        self._differences = 0, NO_TIMES
        protocol = self.session.protocol
        if protocol is not None and not self.rules[0].recorded:
            self.rules = (rules_of(self.session)[0], *self.rules[1:])

    @property
    def unit(self) -> str:
        """What is counted in a game, as a label of at most 8 letters."""
        protocol = self.session.protocol
        return "score" if protocol is None else words_of(protocol.game).units[1]

    def warm_up(self) -> None:
        """Load the compiled code that names placements: a second or two, a minute the first time. In any
        thread.
        """
        protocol = self.session.protocol
        if protocol is not None and isinstance(protocol.domain, TetrisConfig):
            from core.tetris.afterstate import Tetris

            domain = Tetris(protocol.domain)
            domain.placements(domain.initial(0))
        self.warm = True

    # --- credit ---------------------------------------------------------------------------------------------

    @property
    def rule(self) -> Rule:
        """The rule on the strip."""
        return self.rules[self._rule]

    def next_rule(self, by: int) -> None:
        """Switch to the next rule, or the one before."""
        self._rule = (self._rule + by) % len(self.rules)

    def strip(self, time_ns: int) -> tuple[CreditStrip | None, Press | None]:
        """Return the newest press at a time, and its credit; no credit for a press that was refused."""
        row = self.session.press_near(time_ns)
        if row < 0:
            return None, None
        press = self.session.press_at(row)
        return self._strip(row, self._rule), press

    def _strip_of(self, row: int, rule: int) -> CreditStrip | None:
        press, chosen = self.session.press_at(row), self.rules[rule]
        if press.kind not in ("good", "bad", "neither", "taken back"):
            return None
        return strip_of(self.session, press, chosen.delay, recorded=chosen.recorded)

    # --- decisions ------------------------------------------------------------------------------------------

    @property
    def ready(self) -> bool:
        """Whether nothing is being worked out any more."""
        return self._own.done and (self.other is None or self.other.done)

    @property
    def own_words(self) -> str:
        """Say how the values of the session's agent were found."""
        return self._own.words

    @property
    def other_words(self) -> str:
        """Say how far the what-if is, and how many decisions differ."""
        if self.other is None:
            return ""
        if not self.other.done:
            return self.other.words
        n = len(self.differences)
        return f"{n:,} of {len(self.other.thoughts):,} decisions differ"

    def own_thought(self, step: int) -> Thought | None:
        """Return a decision of the session's agent by the row of its step."""
        return self._own.thoughts[step]

    def other_thought(self, step: int) -> Thought | None:
        """Return the same decision of the what-if's agent."""
        return None if self.other is None else self.other.thoughts[step]

    def toggle_what_if(self) -> str:
        """Begin a what-if, or end it; return what was done, in words.

        It is the command's (`--credit`, `--scheme`), else the session's protocol with the credit rule on the
        strip.
        """
        if self.other is not None and (self._asked is not None or self.other_name == self.rule.words):
            self.other, self._differences = None, (0, NO_TIMES)
            return "What-if ended"
        protocol = self.session.protocol
        if protocol is None:
            return "A what-if needs states and actions; this recording holds none"
        if self._asked is not None:
            self.other_name, chosen = self._asked
        else:
            self.other_name = self.rule.words
            credit = msgspec.structs.replace(protocol.agent.credit, delay=self.rule.delay)
            agent = msgspec.structs.replace(protocol.agent, credit=credit)
            chosen = msgspec.structs.replace(protocol, agent=agent, delay_of="rule")
        self.other = self._begin(chosen)
        self._differences = (0, NO_TIMES)
        return f"What if: {self.other_name}"

    @property
    def differences(self) -> NDArray[np.int64]:
        """Times at which steps came on screen that the what-if's agent would have decided otherwise,
        ascending.
        """
        if self.other is None:
            return NO_TIMES
        n = len(self.other.thoughts)
        if n != self._differences[0]:
            self._differences = n, self._find_differences(n)
        return self._differences[1]

    def _find_differences(self, n: int) -> NDArray[np.int64]:
        assert self.other is not None
        other = self.other.thoughts.chosen()[:n]
        steps = self.session.steps[: len(other)]
        recorded = steps["action"]
        if self.session.imported:
            # Logs of other programs do not hold actions: the two agents are compared with each other.
            recorded = self._own.thoughts.chosen()
            other, steps = other[: len(recorded)], steps[: len(recorded)]
            recorded = recorded[: len(other)]
        shown = np.where(steps["shown"] >= 0, steps["shown"], steps["time"])
        return np.sort(np.asarray(shown[other != recorded], dtype=np.int64))

    def name_of(self, person: int) -> str:
        """Return the code of a participant by number (`KeyPressed.person`), where the recording has one."""
        codes = self.session.people
        return codes[person] if 0 <= person < len(codes) else f"person {person + 1}"

    def namer(self, step: int) -> Callable[[int], str]:
        """Return what names the actions of a step, in at most 8 letters."""
        protocol = self.session.protocol
        if protocol is not None and isinstance(protocol.domain, KeepawayConfig):
            return lambda action: "hold" if action == HOLD else f"pass {action}"
        placements = self.placements(step)
        return lambda action: (
            f"t{placements[action][0]} c{placements[action][1] + 1}"
            if action < len(placements)
            else f"#{action}"
        )

    # --- marks on the game ----------------------------------------------------------------------------------

    def placements(self, step: int) -> list[tuple[int, int]]:
        """Return (orientation, leftmost column) of each action at a step of Tetris; nothing where it is not
        known.
        """
        known = self._board_of(step) if step >= 0 and self.warm else None
        return [] if known is None else list(self._candidates(step, known))

    _board: tuple[int, Board] = (-1, ())

    def _board_of(self, step: int) -> Board | None:
        return self._board[1] if self._board[0] == step else None

    def candidates(self, step: int, board: Board) -> dict[tuple[int, int], str]:
        """Return where candidates would come to rest: a rank for each cell (row from the bottom, column).

        The best five of the agent are numbered; the what-if's best is marked `1'`.
        """
        self._board = step, board
        own, other = self.own_thought(step), self.other_thought(step)
        if not self.warm or (own is None and other is None):
            return {}
        placements = self._candidates(step, board)
        piece = self._piece(step)
        marks: dict[tuple[int, int], str] = {}
        differs = own is not None and other is not None and other.chosen != own.chosen
        wanted = [("1'", other.chosen)] if differs and other is not None else []
        wanted += [] if own is None else [(str(n), one.action) for n, one in enumerate(own.best, 1)]
        for mark, action in wanted:
            if action < len(placements):
                orientation, column = placements[action]
                row = landing_row(board, piece, orientation, column)
                for cell in FallingPiece(piece, orientation, row, column).cells():
                    marks.setdefault(cell, mark)
        return marks

    def _piece(self, step: int) -> int:
        return PlacedPiece.of(self.session.step_taken(step)).piece

    def _candidates_of(self, step: int, board: Board) -> tuple[tuple[int, int], ...]:
        from core.tetris.afterstate import Tetris, TetrisState  # here, not above: compiled code comes with it

        protocol = self.session.protocol
        assert protocol is not None
        assert isinstance(protocol.domain, TetrisConfig)
        domain = Tetris(protocol.domain)
        if self.session.imported:
            found = domain.placements_on(board, self._piece(step))
        else:
            game = int(self.session.steps["episode"][step])
            k = step - int(self.session.games["first_step"][game])
            found = domain.placements(TetrisState(board, int(self.session.games["seed"][game]), k))
        return tuple((int(orientation), int(column)) for orientation, column in found)

    def bars(self, step: int) -> dict[int, tuple[float, str, bool]]:
        """Return f(R, H) of each option at a step of Keepaway.

        Returns:
            For each keeper a fraction of the best, a figure, and whether it was chosen. The bar of holding
            the ball is the deciding keeper's own.
        """
        thought = self.own_thought(step) if step >= 0 else None
        if thought is None:
            return {}
        receivers = self.receivers(step)
        finite = [one.f for one in thought.actions if np.isfinite(one.f)]
        low, high = min(finite, default=0.0), max(finite, default=1.0)
        return {
            receivers[one.action]: (
                (one.f - low) / (high - low) if high > low else 1.0,
                f"{one.f:.1f}",
                one.action == thought.chosen,
            )
            for one in thought.actions
            if one.action in receivers and np.isfinite(one.f)
        }

    def receivers(self, step: int) -> dict[int, int]:
        """Return which keeper each option of a step passes to; of holding the ball, who holds it."""
        row, mates = self.drawn_receivers()
        if row != step:
            return {}
        keeper = ChosenOption.of(self.session.step_taken(step)).keeper
        return {HOLD: keeper, **dict(enumerate(mates, HOLD + 1))}

    # --- tags -----------------------------------------------------------------------------------------------

    def export_tags(self) -> str:
        """Write the tagged moments beside the recording; return what was done, in words."""
        if not self.tags.all:
            return "No tags yet: 1-9 mark a moment"
        out = self.path.with_name(f"{self.path.name}.tags.csv")
        try:
            write_tags_csv(out, self.tags.all, self._facts, self.session.start_ns)
        except OSError as error:
            return f"{out} cannot be written: {error.strerror}"
        return f"{len(self.tags.all)} tagged moments: {out}"

    def _facts(self, time_ns: int) -> dict[str, object]:
        moment = self.session.at(time_ns)
        row = self.session.press_near(time_ns)
        frames, steps, games = self.session.frames, self.session.steps, self.session.games
        return {
            "participant": self.session.index.header.participant,
            "game": moment.game + 1,
            "step": int(steps["number"][moment.step]) if moment.step >= 0 else "",
            "frame": int(frames["number"][moment.frame]) if moment.frame >= 0 else "",
            "last_press": int(self.session.presses["number"][row]) if row >= 0 else "",
            "last_press_was": self.session.press_at(row).words if row >= 0 else "",
            "weight": float(games["weight"][moment.game]) if moment.game >= 0 else "",
        }


def nothing_worked_out(words: str) -> Working:
    """Return what stands for decisions that cannot be known."""
    return Working(Thoughts(Path("/nonexistent")), None, words)
