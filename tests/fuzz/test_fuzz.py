"""Every reader against thousands of broken inputs: seconds by default, an hour by name.

By name: `pytest -n 0 -m slow tests/fuzz` (ARL_FUZZ_S seconds in all, 3600 by default); one reader alone:
`python -m tests.fuzz.run SECONDS SEED NAME`.
"""

import os

import pytest

from tests.fuzz.run import fuzz
from tests.fuzz.targets import TARGETS


@pytest.mark.parametrize("name", TARGETS)
def test_broken_inputs_are_refused_with_the_documented_error(name):
    found = fuzz(TARGETS[name], inputs=TARGETS[name].default)
    assert found.sound, str(found)
    assert 0 < found.refused <= found.inputs


@pytest.mark.slow
@pytest.mark.parametrize("name", TARGETS)
def test_an_hour_of_broken_inputs(name):
    seconds = float(os.environ.get("ARL_FUZZ_S", "3600")) / len(TARGETS)
    found = fuzz(TARGETS[name], seconds=seconds, root_seed=int.from_bytes(os.urandom(4), "big"))
    assert found.sound, str(found)
