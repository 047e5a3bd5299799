"""Keepaway keeps the contract of a domain, whatever its size and whatever players see."""

import pytest

from core.keepaway.domain import Keepaway
from core.keepaway.pitch import KeepawayConfig
from tests.contracts.domain_contract import DomainContract

CONFIGS = {
    "3v2, noisy": Keepaway(KeepawayConfig()),
    "3v2, exact, one human model": Keepaway(KeepawayConfig(exact_state=True), shared_feedback=True),
    "4v3, limited vision": Keepaway(KeepawayConfig(4, 3, 30.0, 30.0, view_angle_deg=90.0)),
}


class TestKeepaway(DomainContract):
    """All of the contract, for several games."""

    @pytest.fixture(params=CONFIGS.values(), ids=CONFIGS)
    def domain(self, request):
        return request.param
