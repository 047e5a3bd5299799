"""Whether the inputs of a recording can have happened: checked before anything is run again.

A recording's seal finds damage, but who changes a file can seal it anew. What the screen and the participant
did must then still fit together. The gate that decided which presses count and the ledger of frames are
followed again from the protocol (`core.feedback.keys`, `core.feedback.frames`): each press must come out as
it was recorded. Times must allow cause and effect: a frame follows the step that it shows, and an input
precedes the output that took it in.

What no file can tell is listed in `SECURITY.md`.
"""

from collections import deque
from collections.abc import Sequence
from itertools import count

import msgspec

from core.events import (
    CreditGiven,
    EpisodeStarted,
    Event,
    FrameShown,
    Input,
    KeyPressed,
    Output,
    PressRetracted,
    QuestionAnswered,
    QuestionPosed,
    Resumed,
    ScreenCleared,
    StepTaken,
    StopAsked,
    TimeGap,
    WrongPressAsked,
)
from core.feedback.asking_config import AskingConfig
from core.feedback.frames import FrameLedger
from core.feedback.keys import KeyConfig, PressGate, WrongPressPlan
from core.feedback.layouts import KeyReader, Reading, possible_readings
from core.feedback.people import PeopleGate
from core.numerics.clock import LONGEST_NS
from core.recording.reader import RecordingError
from core.recording.schema import Header
from core.recording.stored import AnyRecording
from core.session.answers import Impossible, QuestionsFollowed, refuse

CLOCKS_AGREE_NS = (1_000_000, 50_000_000)
"""Times that two processes read from one clock may differ by its resolution in the wrong order: at least and
at most so much is allowed for."""


def check_inputs(
    recording: AnyRecording, keys: KeyConfig | Sequence[KeyConfig], asking: AskingConfig | None = None
) -> None:
    """Check that every input of a recording can have happened where it stands.

    Args:
        recording: live or simulated. Imported recordings have no gate: nothing is checked.
        keys: of the recording's own protocol; of several participants at one keyboard those of each.
        asking: of it, too: keys and limit of answers. None: the defaults.

    Raises:
        RecordingError: one cannot; with its line and the reason.
    """
    if recording.header.origin == "imported":
        return
    # An older part may have been shifted to times before zero (`core.recording.joined`).
    screen = _Screen(
        recording.header,
        (keys,) if isinstance(keys, KeyConfig) else tuple(keys),
        QuestionsFollowed(asking or AskingConfig()),
        earliest_ns=-LONGEST_NS if recording.older else 0,
    )
    for index, event in enumerate(recording.events):
        try:
            screen.take(event)
        except Impossible as error:
            raise RecordingError(
                f"{recording.path}:{recording.line_of(index)}: {error}. No session records this: the file "
                "was changed after it was recorded, and sealed anew"
            ) from error


class _RecordedReader(KeyReader):
    """Reads each key as the recording did: the participant's language and earlier keys are not in the
    file.
    """

    def __init__(self) -> None:
        super().__init__()
        self.reading: Reading | None = None

    def read(self, key: str) -> Reading | None:
        return self.reading


class _Screen:
    """The screen's side of a session: takes in events in the order of the file, as the live screen did."""

    def __init__(
        self,
        header: Header,
        keys: Sequence[KeyConfig],
        questions: QuestionsFollowed,
        *,
        earliest_ns: int = 0,
    ) -> None:
        self._questions = questions
        self._earliest_ns = earliest_ns
        # Simulated sessions are drawn on the real screens, too: these have a terminal.
        self._live = header.origin == "live" or bool(header.terminal)
        least_ns, most_ns = CLOCKS_AGREE_NS
        self._clocks_agree_ns = min(max(least_ns, header.clock_resolution_ns), most_ns)
        # Version 1 was written by programs whose covers could follow each other.
        self._strict_covers = self._live and header.version > 1
        self._keys = keys[0]
        self._people = keys if len(keys) > 1 else ()
        self._frames = FrameLedger()
        self._numbers = count()
        self._reader = _RecordedReader()
        self._gates: dict[int, PressGate | PeopleGate] = {}
        self._wrong_presses = WrongPressPlan(
            self._keys.wrong_press_rate if self._live else 0.0, header.root_seed
        )
        self._due: deque[Input] = deque()  # inputs that must come next
        self._playing = False
        self._covered = False
        self._stopped = False
        self._last_frame = -1
        self._last_flush_ns = earliest_ns
        self._last_shown = -1
        self._step_times: dict[int, int] = {}
        self._last_press_ns: dict[tuple[str, int], int] = {}
        self._waiting: deque[int] = deque()  # times of inputs that no output has counted yet
        self._counted = 0
        self._output_ns = earliest_ns

    def take(self, event: Event) -> None:
        """Take in the next event.

        Raises:
            Impossible: it cannot have happened here.
        """
        if isinstance(event, TimeGap) and event.joint:
            self._go_on()
        if self._due and isinstance(self._due[0], WrongPressAsked):
            self._take_request(event)
        elif self._due:
            expected = self._due.popleft()
            if event != expected:
                refuse(
                    f"expected {_told(expected)}, which follows from the press before, found {_told(event)}"
                )
            self._note_time(expected)
        elif isinstance(event, Output):
            self._take_output(event)
        else:
            self._take_input(event)

    def _go_on(self) -> None:
        """Begin anew where the session goes on in another file: the screen's process was a new one."""
        asked = any(gate.wrong_asked for gate in self._gates.values() if isinstance(gate, PressGate))
        self._due.clear()  # what would have come next belongs to the game that was cut short
        self._playing = self._covered = False
        self._questions.forget()
        self._gates.clear()
        if asked:
            self._gate_of_first().wrong_asked = True

    # --- inputs ---------------------------------------------------------------------------------------------

    def _take_input(self, event: Input) -> None:
        if self._stopped and self._strict_covers:
            refuse(f"{_told(event)} behind the request to stop, after which the screen takes nothing in")
        self._note_time(event)
        match event:
            case FrameShown():
                self._take_frame(event)
            case KeyPressed():
                self._take_press(event)
            case ScreenCleared(time_ns=time_ns):
                if self._covered and self._strict_covers:
                    refuse("the screen is covered, and was covered before")
                self._covered = True
                self._frames.cleared(time_ns)
            case Resumed():
                if not self._covered and self._strict_covers:
                    refuse("the screen is uncovered, and was not covered before")
                self._covered = False
            case TimeGap(last_ns=last_ns, time_ns=time_ns):
                if last_ns > time_ns:
                    refuse(f"a gap ends at {time_ns} ns, before it begins at {last_ns} ns")
                self._frames.cleared(last_ns)
            case PressRetracted(press=press):
                refuse(f"press {press} is taken back, and nothing that was pressed before does so")
            case WrongPressAsked():
                refuse(
                    "the participant is asked for a wrong press, where the protocol and the seed ask for none"
                )
            case StopAsked():
                self._stopped = True
            case QuestionAnswered():
                self._questions.answered(event, self._clocks_agree_ns, covered=self._covered)
            case _:
                pass  # the window's focus: nothing follows from it

    def _take_frame(self, shown: FrameShown) -> None:
        frame, step, flushed_ns = shown.frame, shown.step, shown.flushed_ns
        if frame <= self._last_frame:
            refuse(f"frame {frame} is shown after frame {self._last_frame}")
        if flushed_ns < self._last_flush_ns:
            refuse(f"frame {frame} is shown at {flushed_ns} ns, the frame before at {self._last_flush_ns} ns")
        if self._covered and self._strict_covers:
            refuse(f"frame {frame} is shown while something else covers the screen")
        if step < -1 or (step >= 0 and step not in self._step_times):
            refuse(f"frame {frame} shows step {step}, which is none of the last two steps taken")
        if 0 <= step < self._last_shown:
            refuse(f"frame {frame} shows step {step} after step {self._last_shown}")
        if step >= 0 and flushed_ns < self._step_times[step] - self._clocks_agree_ns:
            refuse(
                f"frame {frame} shows step {step} at {flushed_ns} ns, before the step was taken at "
                f"{self._step_times[step]} ns"
            )
        self._last_frame, self._last_flush_ns = frame, flushed_ns
        self._last_shown = max(step, self._last_shown)
        self._frames.recorded(shown)

    def _take_press(self, pressed: KeyPressed) -> None:
        gate = self._gate(pressed.person)
        by = (pressed.source, pressed.person)
        if pressed.time_ns < self._last_press_ns.get(by, self._earliest_ns):
            refuse(
                f"press {pressed.press} is at {pressed.time_ns} ns, the one before at "
                f"{self._last_press_ns[by]} ns"
            )
        self._last_press_ns[by] = pressed.time_ns
        self._read(pressed)
        gate.frame, gate.step = self._frames.at(pressed.time_ns)
        gate.covered = self._covered
        if not self._live and isinstance(gate, PressGate):
            gate.wrong_asked = pressed.asked_wrong  # a simulated participant knows by itself
        came, *taken_back = gate.judge(pressed.key, pressed.time_ns, source=pressed.source)
        if came != pressed:
            refuse(f"press {pressed.press}: {_difference(pressed, came)}")
        self._due.extend(taken_back)
        self._questions.pressed(pressed)
        if pressed.verdict == "accepted":
            self._wrong_presses.accepted()

    def _read(self, pressed: KeyPressed) -> None:
        """Let the gate read the key as it was recorded, if it can be read so."""
        self._reader.reading = None
        if pressed.read_as or pressed.layout:
            self._reader.reading = Reading(pressed.read_as, pressed.layout)
            if self._reader.reading not in possible_readings(pressed.key):
                refuse(
                    f"press {pressed.press}: the key {pressed.key!r} does not stand for {pressed.read_as!r} "
                    f"in the layout {pressed.layout!r}"
                )

    def _gate(self, person: int) -> PressGate | PeopleGate:
        """Return the gate of a press: of several participants at one keyboard one for all, which tells by the
        key whose it is.
        """
        number = 0 if self._people else person
        if number not in self._gates:
            gate = (
                PeopleGate(self._people, numbers=self._numbers)
                if self._people
                else PressGate(self._keys, person=person, numbers=self._numbers)
            )
            gate.reader = self._reader
            gate.playing = self._playing
            self._gates[number] = gate
        return self._gates[number]

    def _gate_of_first(self) -> PressGate:
        """Return the gate of the one who is asked for wrong presses: never of several participants."""
        gate = self._gate(0)
        return gate if isinstance(gate, PressGate) else PressGate(self._keys)

    def _take_request(self, event: Event) -> None:
        """Take in the request for a wrong press that must come now."""
        expected = self._due.popleft()
        assert isinstance(expected, WrongPressAsked), "looked at before"
        if not isinstance(event, WrongPressAsked) or event.step != expected.step:
            refuse(
                f"expected the request for a wrong press at step {expected.step}, which follows from the "
                f"seed, found {_told(event)}"
            )
        self._note_time(event)

    def _note_time(self, event: Input) -> None:
        time_ns = _time_of(event)
        if not self._earliest_ns <= time_ns <= LONGEST_NS:
            refuse(f"{_told(event)} at {time_ns} ns: no clock of a session says so")
        self._waiting.append(time_ns)

    # --- outputs --------------------------------------------------------------------------------------------

    def _take_output(self, output: Output) -> None:
        if isinstance(output, CreditGiven):
            return
        self._check_counted(output.inputs, output.time_ns)
        match output:
            case EpisodeStarted():
                self._playing = True
                for gate in self._gates.values():
                    gate.episode_started()
            case StepTaken(step=step, time_ns=time_ns):
                self._step_times = {
                    known: at_ns for known, at_ns in self._step_times.items() if known == step - 1
                } | {step: time_ns}
                if self._wrong_presses.due(self._gate_of_first()):
                    self._due.append(WrongPressAsked(time_ns=time_ns, step=step))
            case QuestionPosed():
                self._questions.posed(output)
            case _:
                pass

    def _check_counted(self, inputs: int, time_ns: int) -> None:
        """Check that the inputs an output has taken in are there, and came before it."""
        if not self._output_ns <= time_ns <= LONGEST_NS:
            refuse(f"an output at {time_ns} ns follows one at {self._output_ns} ns")
        if not self._counted <= inputs <= self._counted + len(self._waiting):
            refuse(
                f"an output has taken in {inputs} inputs; there are {self._counted + len(self._waiting)} "
                f"before it, "
                f"and the one before had taken in {self._counted}"
            )
        while self._counted < inputs:
            at_ns = self._waiting.popleft()
            self._counted += 1
            if at_ns > time_ns + self._clocks_agree_ns:
                refuse(
                    f"an output at {time_ns} ns has taken in input {self._counted - 1}, which came at "
                    f"{at_ns} ns: later"
                )
        self._output_ns = time_ns


def _time_of(event: Input) -> int:
    return event.flushed_ns if isinstance(event, FrameShown) else event.time_ns


def _told(event: Event) -> str:
    """Return an event's kind, and its press where it has one."""
    kind = str(event.__struct_config__.tag)
    return f"{kind} (press {event.press})" if isinstance(event, KeyPressed | PressRetracted) else kind


def _difference(recorded: KeyPressed, follows: KeyPressed | PressRetracted) -> str:
    """Say in which field a press is not what follows from protocol, frames and earlier presses."""
    before, now = msgspec.structs.asdict(recorded), msgspec.structs.asdict(follows)
    field = next(name for name in before if before[name] != now[name])
    return (
        f"its {field} is {before[field]!r}; from the protocol, the frames and the presses before follows "
        f"{now[field]!r}"
    )
