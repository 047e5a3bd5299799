"""Learned policies on disk."""

import io
import re
import tracemalloc
import zipfile
from pathlib import Path

import msgspec
import numpy as np
import pytest

from core.keepaway.pitch import KeepawayConfig
from core.keepaway.policy_file import PolicyFileError, PolicyHeader, SavedPolicy, load_policy, save_policy
from core.learners.sarsa import SarsaConfig
from tests.full_disk import files_end_at

HEADER = PolicyHeader(
    task=KeepawayConfig(n_keepers=4, n_takers=3, length_m=30.0),
    learner=SarsaConfig(trace_decay=0.5),
    n_tilings=8,
    root_seed=3,
    hours=0.5,
    episodes=300,
    duration_s=6.5,
    created_utc="2026-11-22T10:00:00Z",
    software={"arl-tui": "0.1.0"},
)


@pytest.fixture
def saved(tmp_path: Path) -> tuple[Path, SavedPolicy]:
    n_tiles = SavedPolicy(HEADER, _weights(1)).weights.shape[2]
    path = tmp_path / "keepers.npz"
    policy = SavedPolicy(HEADER, _weights(2))
    assert policy.weights.shape == (4, 4, n_tiles)
    save_policy(path, policy)
    return path, policy


def _weights(seed: int) -> np.ndarray:
    from core.keepaway.policy_file import _empty

    return np.random.default_rng(seed).normal(size=_empty(HEADER).weights.shape)


def test_what_was_saved_comes_back(saved: tuple[Path, SavedPolicy]):
    path, policy = saved
    back = load_policy(path)
    assert back.header == HEADER
    assert np.array_equal(back.weights, policy.weights)
    assert list(path.parent.iterdir()) == [path]


def test_learners_have_the_weights_and_go_on_from_them(saved: tuple[Path, SavedPolicy]):
    back = load_policy(saved[0])
    sarsa = back.sarsa()
    assert np.array_equal(sarsa.weights, back.weights)
    assert sarsa.trace_decay == 0.5
    assert sarsa.coder.n_tilings == 8
    sarsa.weights[:] = 0.0
    assert back.weights.any()


def test_a_shared_policy_has_one_set_of_weights(tmp_path: Path):
    header = msgspec.structs.replace(HEADER, learner=SarsaConfig(shared_weights=True))
    save_policy(tmp_path / "one.npz", SavedPolicy(header, _weights(1)[:1]))
    assert load_policy(tmp_path / "one.npz").sarsa().weights.shape[0] == 1


def test_weights_of_another_task_are_an_error():
    with pytest.raises(PolicyFileError, match=r"4 keepers against 3 takers have shape .*, got \(3, 4, 10\)"):
        SavedPolicy(HEADER, np.zeros((3, 4, 10)))


def test_weights_that_are_no_numbers_are_an_error():
    weights = _weights(1)
    weights[0, 0, 0] = np.nan
    with pytest.raises(PolicyFileError, match="not finite"):
        SavedPolicy(HEADER, weights)


def write_archive(path: Path, **arrays: np.ndarray) -> Path:
    np.savez(path, **arrays)
    return path


def as_bytes(text: bytes) -> np.ndarray:
    return np.frombuffer(text, np.uint8)


def test_files_that_are_no_policy_are_named_with_the_reason(tmp_path: Path, saved: tuple[Path, SavedPolicy]):
    text = tmp_path / "notes.txt"
    text.write_text("hello")
    empty = tmp_path / "empty.npz"
    empty.write_bytes(b"")
    cut = tmp_path / "cut.npz"
    cut.write_bytes(saved[0].read_bytes()[:500])
    objects = write_archive(tmp_path / "objects.npz", header=np.array([{}], dtype=object))
    other = write_archive(tmp_path / "other.npz", x=np.zeros(3))
    for path in (text, empty, cut, objects, other):
        with pytest.raises(
            PolicyFileError, match=rf"{path.name}: not a policy of Keepaway .*arl train keepaway"
        ):
            load_policy(path)


def test_files_of_another_kind_or_version_are_named_with_the_reason(tmp_path: Path):
    weights = _weights(1)
    for k, (header, reason) in enumerate(
        [
            (b'{"format": "something else", "version": 1}', "got 'something else' of version 1"),
            (b'{"format": "arl keepaway policy", "version": 2}', "got 'arl keepaway policy' of version 2"),
            (b'{"format": "arl keepaway policy", "version": 1}', "missing required field"),
            (b"not json", "JSON is malformed"),
        ]
    ):
        path = write_archive(tmp_path / f"{k}.npz", header=as_bytes(header), weights=weights)
        with pytest.raises(PolicyFileError, match=reason):
            load_policy(path)


def test_a_file_that_is_not_there_is_an_error_of_the_system(tmp_path: Path):
    with pytest.raises(OSError, match=r"none\.npz"):
        load_policy(tmp_path / "none.npz")


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"n_tilings": 10**9}, "n_tilings is 1..128 tilings, got 1000000000"),
        ({"n_tilings": 0}, "n_tilings is 1..128"),
        ({"task": KeepawayConfig(length_m=1e6)}, "expected a number 10 to 200 metres"),
        ({"learner": SarsaConfig(step_size=1e300)}, "expected a number 0 to 1000000"),
    ],
)
def test_a_header_that_asks_for_the_impossible_is_refused_before_any_memory_is(tmp_path: Path, changes, told):
    header = msgspec.structs.replace(HEADER, **changes)
    path = write_archive(
        tmp_path / "p.npz",
        header=np.frombuffer(msgspec.json.encode(header), np.uint8),
        weights=np.zeros((3, 3, 10)),
    )
    with pytest.raises(PolicyFileError, match=re.escape(told)):
        load_policy(path)


def archive(path: Path, *, header: bytes | None = None, weights: bytes | None = None) -> Path:
    """An archive whose members are these bytes; those of a good policy where None."""
    good = {"header": np.frombuffer(msgspec.json.encode(HEADER), np.uint8), "weights": _weights(2)}
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as out:
        for name, content in (("header", header), ("weights", weights)):
            if content is None:
                member = io.BytesIO()
                np.save(member, good[name])
                content = member.getvalue()
            out.writestr(f"{name}.npy", content)
    return path


def npy(shape: str, descr: str = "<f8", content: bytes = b"") -> bytes:
    text = f"{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}\n".encode()
    return b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text + content


@pytest.mark.parametrize(
    ("weights", "told"),
    [
        (npy("(1000000000000,)"), "says its shape is"),
        (npy("(-1,)"), "says its shape is"),
        (npy("(4, 4, 10)", "<c16", b"\0" * 160), "of the type complex128, expected float64"),
        (npy("(1,)", "|O", b"\0" * 8), "of the type object"),
        (npy("()" * 3000), "not a policy"),
        (npy("(1,)", "<f8", b"\0" * 8), "have shape"),
        (b"\x93NUMPY\x09\x00", "not a policy"),
        (b"", "not a policy"),
        (b"\0" * (1 << 26), "weights holds more than"),
    ],
    ids=[
        "petabytes",
        "negative",
        "complex",
        "objects",
        "nested",
        "another shape",
        "version 9",
        "empty",
        "bomb",
    ],
)
def test_archives_that_claim_the_impossible_are_refused_in_bounded_memory(
    tmp_path: Path, weights: bytes, told: str
):
    path = archive(tmp_path / "bad.npz", weights=weights)
    tracemalloc.start()
    try:
        with pytest.raises(PolicyFileError, match=told):
            load_policy(path)
        assert tracemalloc.get_traced_memory()[1] < 40_000_000
    finally:
        tracemalloc.stop()


def test_cut_encrypted_and_wrong_archives_are_refused(tmp_path: Path):
    path = archive(tmp_path / "whole.npz")
    content = path.read_bytes()
    assert load_policy(path).header == HEADER
    encrypted = bytearray(content)
    for mark, offset in ((b"PK\x03\x04", 6), (b"PK\x01\x02", 8)):
        at = -1
        while (at := content.find(mark, at + 1)) >= 0:
            encrypted[at + offset] |= 1
    alone = io.BytesIO()
    np.save(alone, _weights(1))
    for bad in (
        content[: len(content) // 2],
        content[:-30],
        bytes(encrypted),
        alone.getvalue(),
        b"",
        content[50:],
    ):
        path.write_bytes(bad)
        with pytest.raises(PolicyFileError, match=r"whole\.npz: not a policy of Keepaway"):
            load_policy(path)
    assert list(tmp_path.iterdir()) == [path]


def test_half_a_policy_is_not_left_on_a_full_disk(saved: tuple[Path, SavedPolicy]):
    path, policy = saved
    before = path.read_bytes()
    with files_end_at(100), pytest.raises(OSError, match="too large"):
        save_policy(path, policy)
    assert list(path.parent.iterdir()) == [path]
    assert path.read_bytes() == before
