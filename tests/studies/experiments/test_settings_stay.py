"""Settings of the published experiments are those that their trials were played with: seals go by them."""

import hashlib
import json

import msgspec
import pytest

from studies.experiments.sweep import describe_settings, load_experiment

DIGESTS = {
    "fig5": "44d42b1b68d5",
    "fig6": "05eb201c8e1f",
    "fig7": "30107b6534f8",
    "robustness": "7f8275dcad0b",
    "robustness-keepaway": "563726d2e5fe",
    "credit": "4d06d205c17c",
    "features": "42802045d5bd",
}
"""Of the program at 0.2.0. A new setting is named in its table's `LATER`, and is left out at its default."""


@pytest.mark.parametrize(("name", "digest"), DIGESTS.items())
def test_a_new_setting_does_not_make_stored_trials_those_of_another_experiment(
    name: str, digest: str
) -> None:
    settings = describe_settings(load_experiment(name).conditions)
    assert hashlib.sha256(json.dumps(settings, sort_keys=True).encode()).hexdigest()[:12] == digest


@pytest.mark.parametrize(("name", "count"), [("fig6", 2), ("robustness", 16)])
def test_what_a_condition_writes_is_what_it_plays(name: str, count: int) -> None:
    written = [each for each in load_experiment(name).conditions if each.written is not None]
    assert len(written) == count
    for each in written:
        learner = each.written["gradient"]
        assert each.settings == msgspec.structs.replace(each.written["protocol"], learner=learner)
