"""What all tests share: no test fails because a machine is slow, and none writes into anybody's home."""

import gc

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
