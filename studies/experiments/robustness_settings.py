"""Rates, rules and names of conditions of the robustness experiment, for its trials and its page."""

from collections.abc import Mapping

from core.combination.config import Equation4, Equation5, RankCorrelation, Signed, Tried, TrustRule

RATES = (0, 10, 30, 50, 80, 100)
"""Wrong presses, per cent."""
RULE = Signed(margin=0.1)
"""The rule under test. Its constants were found on root seeds from 900000 on, and written down before any
trial that the goal is judged by was played (`docs/decisions/margin-of-agreement.md`)."""

FRESH = 1000
"""What is added to the root seeds of the trials that the goal is judged by. Their first twenty, 0 to 19, had
been looked at under other rules when this one was fixed."""

TRUST: dict[str, tuple[str, TrustRule]] = {
    "tried": ("trust by trial", Tried()),
    "signed": ("signed agreement", Signed()),
    "eq4": ("Eq. 4", Equation4()),
    "eq5": ("Eq. 5", Equation5()),
    "chance": ("chance-corrected", Equation4(match="chance-corrected", chance=0.15)),
    "rank": ("rank correlation", RankCorrelation()),
    "rank-signed": ("signed rank correlation", RankCorrelation(signed=True)),
}
"""Rules of trust by name: (label, rule). 0.15 is the agreement of unrelated policies
(`docs/decisions/degree-of-match.md`)."""
MARGIN = "margin"
"""Name of the rule under test in conditions."""

PEOPLE = ("lay", "myopic", "hesitant", "instructed", "bursty", "hasty", "slow", "tiring", "leaves")
"""Simulated participants by name (`core.feedback.simulated_participants`) whom the rule meets beside the
rates, which are the other four."""

ENVIRONMENT = "environment"
FRESH_ENVIRONMENT = "fresh-environment"
GRADIENT = "gradient"


def by_rate(rule: str, names: Mapping[str, object]) -> dict[int, str]:
    """Return the conditions of a rule that are among `names`, by rate in per cent."""
    found = {rate: f"{rule}-{rate:03d}" for rate in RATES}
    return {rate: name for rate, name in found.items() if name in names}
