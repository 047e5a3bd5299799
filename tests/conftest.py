"""What all tests share: no test fails because a machine is slow."""

from hypothesis import HealthCheck, settings

# The first example of a property may compile kernels, and machines differ: hypothesis is not to look at the clock.
settings.register_profile("no clock", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("no clock")
