"""Learned policies on disk."""

import re
from pathlib import Path

import msgspec
import numpy as np
import pytest

from core.keepaway.pitch import KeepawayConfig
from core.keepaway.policy_file import PolicyFileError, PolicyHeader, SavedPolicy, load_policy, save_policy
from core.learners.sarsa import SarsaConfig

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
