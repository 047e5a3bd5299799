"""What is fuzzed: seeds, how an input is made of them, what reads it, and the errors that are documented."""

import io
import math
import random
import shutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import msgspec
import numpy as np

from arl_tui.app import link
from arl_tui.commands.protocol import protocol_lines
from arl_tui.participants import ParticipantDelays, ParticipantError, TaskDelay, delays_path, read_delays
from core.events import FrameShown, KeyPressed
from core.feedback.delays import GammaDelay
from core.keepaway import policy_file
from core.keepaway.pitch import KeepawayConfig
from core.learners.sarsa_config import SarsaConfig
from core.recording.importers.contract import ImporterError
from core.recording.importers.tamer_log import import_tamer_log
from core.recording.reader import Recording, RecordingError, read_recording
from core.recording.stored import stored_recording
from core.recording.summary import summarise_recording
from core.session.inputs import check_inputs
from core.session.protocol import Protocol
from core.session.protocol_file import ProtocolError
from core.session.protocol_reading import load_protocol, protocol_from
from core.session.replay import replay_exactly
from core.session.session import build_session
from core.session.what_if import replay_human_model, watched_steps
from studies.evaluations.table import EvaluationColumns, read_evaluations
from studies.experiments.trial_file import DamagedTrial, Played, read_rows
from studies.lab.read import StudyError, load_study
from studies.reaction_time.read import Columns, read_files
from studies.reaction_time.tables.contract import ReadError
from studies.session_view.session import open_session
from tests.fuzz.mutate import changed_values, mutated, resealed

ROOT = Path(__file__).resolve().parents[2]
REFERENCE = ROOT / "recordings" / "reference"


@dataclass(frozen=True)
class Target:
    """One reader."""

    name: str
    seeds: Callable[[], list[bytes]]
    read: Callable[[Path], object]
    """Takes the file with the input."""
    documented: tuple[type[Exception], ...]
    suffix: str
    make: Callable[[bytes, list[bytes], random.Random], bytes] = mutated
    whole_folder: bool = False
    """The reader must leave nothing behind when it refuses."""
    default: int = 150
    """Inputs in a run of the default suite."""


@cache
def recordings() -> list[bytes]:
    return [path.read_bytes() for path in sorted(REFERENCE.rglob("tetris-*.jsonl"))]


@cache
def short_recordings() -> list[bytes]:
    """The first lines of recordings, of whole games where there are so many: thousands a second are read."""
    return [cut_to(content, n) for content in recordings() for n in (12, 60)]


def cut_to(content: bytes, n_events: int) -> bytes:
    """Return a recording of the first events of another, with an end line and a chain that are right."""
    lines = content.splitlines(keepends=True)[: n_events + 1]
    end = b'{"type":"end","events":%d,"chain":"0"}' % (len(lines) - 1)
    return resealed(b"".join([*lines, end]))


def _read_recording(path: Path) -> object:
    return summarise_recording(read_recording(path))


def _stored(path: Path) -> object:
    """Read a recording on the disk, and in memory: what both take is the same."""
    on_disk = stored_recording(path, from_bytes=0)
    in_memory = read_recording(path)
    if on_disk is not None:
        same = tuple(on_disk.events) == in_memory.events and on_disk.notes == in_memory.notes
        assert same or any(math.isnan(value) for value in _numbers(in_memory)), "two readings of one file"
        assert on_disk.summary == summarise_recording(in_memory), "two summaries of one file"
    return on_disk


def _index(path: Path) -> object:
    """Open a recording as the viewer does, and look at its last moment."""
    session = open_session(path)
    return session.at(session.end_ns)


def _numbers(recording: Recording) -> Iterator[float]:
    """Yield the numbers of a recording that may be NaN, which equals nothing."""
    for event in recording.events:
        yield from (value for value in msgspec.structs.astuple(event) if isinstance(value, float))


def _resealed(seed: bytes, others: list[bytes], rng: random.Random) -> bytes:
    return resealed(mutated(seed, others, rng)) if rng.random() < 0.5 else changed_values(seed, rng)


def _check(path: Path) -> object:
    recording = read_recording(path)
    try:
        protocol = protocol_from(recording.header.protocol)
    except msgspec.ValidationError:
        return None  # said by whoever asks for it
    check_inputs(recording, protocol.keys)
    return summarise_recording(recording)


@cache
def _small_protocol() -> Protocol:
    return protocol_from(read_recording(next(REFERENCE.glob("version-2/tetris-l*"))).header.protocol)


def _replay(path: Path) -> object:
    recording = read_recording(path)
    try:
        protocol = protocol_from(recording.header.protocol)
    except msgspec.ValidationError:
        return None
    first = _small_protocol()
    small = (protocol.domain, protocol.learner, protocol.session) == (
        first.domain,
        first.learner,
        first.session,
    )
    if not small or protocol.delay_of != "rule":
        return None  # a session of hours may be asked for in good faith
    replay_exactly(recording, build_session(protocol, recording.header.root_seed))
    replay_human_model(recording, protocol, watched_steps(recording, protocol), count=lambda press: True)
    return None


@cache
def protocols() -> list[bytes]:
    written = [
        "\n".join(protocol_lines(load_protocol(None, game=game))).encode() for game in ("tetris", "keepaway")
    ]
    return written + [
        path.read_bytes() for path in sorted(ROOT.rglob("*.toml")) if path.stat().st_size < 20_000
    ]


@cache
def studies() -> list[bytes]:
    return [path.read_bytes() for path in sorted((ROOT / "studies" / "lab" / "ready").glob("*.toml"))]


def _study(path: Path) -> object:
    if not (path.parent / "consent.md").exists():
        shutil.copytree(ROOT / "studies" / "lab" / "ready" / "texts", path.parent, dirs_exist_ok=True)
    return load_study(path)


TAMER = b"(params)\n" + b"\n".join(
    b"[%s]:-:[1, 2]:-:%d:%s:true:1259.%d" % (b", ".join([b"0"] * 201 + [b"3"] + [b"0"] * 5), n % 2, presses, n)  # noqa: E501
    for n, presses in enumerate([b"[]", b"[{1.0 @ 1259.5}]", b"[{-1.0 @ 1260.25}, {1.0 @ 1260.5}]", b"[]"])
) + b"\n[]:-:[]:-:0:[]:true:1263.5\nfinished\n"  # fmt: skip


def _tamer(path: Path) -> object:
    target = path.with_name("imported.jsonl")
    try:
        return import_tamer_log(path, target)
    finally:
        if target.exists():
            read_recording(target, allow_truncated=False)
            target.unlink()


def _table(path: Path) -> object:
    """Read a table by the column that its first bytes name, as an experimenter would."""
    rt = "latency ms" if b"latency" in path.read_bytes()[:40] else "rt"
    return read_files(
        [path],
        Columns(
            rt=rt, unit="s" if rt == "rt" else None, participant=None, decimal="." if rt == "rt" else ","
        ),
    )


TABLES = [
    b"participant,rt,correct\nP1,0.5,1\nP1,0.61,1\nP2,0.7,0\nP2,0.45,1\n",
    b"subject;latency ms\nP1;512,5\nP1;601,25\nP2;700,0\n",
    b'[{"trial_type":"html-keyboard-response","rt":512,"response":"j","subject":"a"}]',
    "participant\trt\nÄ1\t0.5\n".encode("utf-16"),
]


def _evaluations() -> list[bytes]:
    return [b"participant_id,time_s,value,delay_s\nP1,1.0,1,0.5\nP1,3.0,-1,0.75\nP2,2.5,1,\n"]


@cache
def policies() -> list[bytes]:
    made = []
    for tilings in (1, 2):
        header = policy_file.PolicyHeader(
            task=KeepawayConfig(), learner=SarsaConfig(), n_tilings=tilings, root_seed=1, hours=0.1, episodes=3,  # noqa: E501
            duration_s=5.0, created_utc="2026-01-01T00:00:00+00:00", software={},
        )  # fmt: skip
        out = io.BytesIO()
        weights = policy_file._empty(header).weights
        np.savez(out, header=np.frombuffer(msgspec.json.encode(header), np.uint8), weights=weights)
        made.append(out.getvalue())
        out = io.BytesIO()
        np.savez_compressed(
            out, header=np.frombuffer(msgspec.json.encode(header), np.uint8), weights=weights + 1j
        )
        made.append(out.getvalue())
    return made


def _link(path: Path) -> object:
    message = path.read_bytes()
    try:
        return link.to_worker(message)
    except link.LinkError:
        return link.from_worker(message)


def messages() -> list[bytes]:
    pressed = KeyPressed(press=1, time_ns=5, key="j", value=1.0, frame=2, step=3, verdict="accepted")
    shown = FrameShown(frame=2, step=3, flushed_ns=4)
    said = [
        pressed,
        shown,
        link.Begin(),
        link.Crashed(error="x", trace="y"),
        link.TakenFor(press=1, value=1, step=2),
    ]
    return [msgspec.msgpack.encode(each) for each in said]


def _delays() -> list[bytes]:
    quantity = [0.5, 0.4, 0.6]
    fit = {
        "task": "simple", "fitted_utc": "2026-01-01T00:00:00+00:00", "files": ["a.jsonl"], "family": "gamma",
        "delay": msgspec.to_builtins(GammaDelay()), "mean_s": quantity, "median_s": quantity, "n_observed": 40,  # noqa: E501
        "n_censored": 0, "left_out": {}, "policy": {}, "shape_identified": True, "shape_reason": "", "verdict": "",  # noqa: E501
    }  # fmt: skip
    known = ParticipantDelays(participant="P01", tasks={"simple": msgspec.convert(fit, TaskDelay)})
    return [msgspec.json.encode(known)]


def _read_delays(path: Path) -> object:
    place = delays_path(path.parent, "P01")
    place.parent.mkdir(exist_ok=True)
    path.replace(place)
    return read_delays(path.parent, "P01")


def _trial(path: Path) -> object:
    return read_rows(path, Played({}, quick=False))


TARGETS = {
    target.name: target
    for target in (
        Target("recordings-raw", recordings, _read_recording, (RecordingError,), ".jsonl"),
        Target("recordings-resealed", short_recordings, _check, (RecordingError,), ".jsonl", _resealed),
        Target("recordings-stored", short_recordings, _stored, (RecordingError,), ".jsonl", _resealed),
        Target("recordings-viewed", short_recordings, _index, (RecordingError,), ".jsonl", _resealed),
        Target(
            "replay",
            short_recordings,
            _replay,
            (RecordingError,),
            ".jsonl",
            lambda s, _, r: changed_values(s, r),
            default=20,
        ),
        Target("protocols", protocols, load_protocol, (ProtocolError,), ".toml"),
        Target("studies", studies, _study, (StudyError,), ".toml"),
        Target("tamer", lambda: [TAMER], _tamer, (ImporterError,), ".log", whole_folder=True),
        Target("tables", lambda: TABLES, _table, (ReadError,), ".csv"),
        Target(
            "evaluations",
            _evaluations,
            lambda path: read_evaluations(path, EvaluationColumns()),
            (ReadError, ImporterError),
            ".csv",
        ),
        Target("policies", policies, policy_file.load_policy, (policy_file.PolicyFileError,), ".npz"),
        Target("delays", _delays, _read_delays, (ParticipantError,), ".json"),
        Target("link", messages, _link, (link.LinkError,), ".msgpack"),
        Target("trials", lambda: [b"episode,reward\n0,1\n1,2.5\n2,nan\n"], _trial, (DamagedTrial,), ".csv"),
    )
}
