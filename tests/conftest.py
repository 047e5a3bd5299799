"""What all tests share: no test fails because a machine is slow, and none writes into anybody's home."""

import gc
from itertools import groupby

import pytest
from hypothesis import HealthCheck, settings

# The first example of a property may compile kernels, and machines differ: hypothesis is not to look at the
# clock.
settings.register_profile("no clock", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("no clock")
# Thousands of tests keep millions of objects alive, and every full collection looks at all of them.
gc.set_threshold(20_000, 20, 50)


@pytest.fixture(autouse=True, scope="session")
def _home_of_tests(tmp_path_factory: pytest.TempPathFactory):
    """Keep what a test does not keep elsewhere in a folder of this run; processes that tests start inherit
    it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ARL_HOME", str(tmp_path_factory.mktemp("arl-home")))
        yield


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Spread sessions in a terminal between the other files: they mostly wait, and where several wait side by
    side a core has nothing to do.
    """
    sessions = [item for item in items if "e2e" in item.path.parts]
    others = [list(group) for _, group in groupby(items, key=lambda item: item.path) if group]
    files = [group for group in others if "e2e" not in group[0].path.parts]
    if not sessions or not files:
        return
    spread: list[pytest.Item] = []
    tests, so_far, placed = sum(map(len, files)), 0, 0
    for group in files:
        spread += group
        so_far += len(group)
        due = len(sessions) * so_far // tests
        spread += sessions[placed:due]
        placed = due
    items[:] = spread


def pytest_collection_finish() -> None:
    """Take what all tests share out of later collections: each drawn session begins with a full one."""
    gc.collect()
    gc.freeze()
