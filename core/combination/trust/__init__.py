"""Rules of trust: how w_h follows from performance and match (section 3.1, Eqs. 4 and 5, and rules of our
own).

Each rule is one file: its settings, its state, how an episode revises it, its part of the fingerprint and
what it needs. A new rule is a file and one line in `TrustRule` (`docs/extending.md`); what the rule forgets
of `core.combination.trust. contract` is then a type error where it is used.
"""

from core.combination.trust.contract import Needs, Rule, Trust
from core.combination.trust.equation_4 import Equation4
from core.combination.trust.equation_5 import Equation5
from core.combination.trust.fixed import FixedWeight
from core.combination.trust.rank_correlation import RankCorrelation
from core.combination.trust.side_by_side import SideBySide
from core.combination.trust.signed import Signed
from core.combination.trust.tried import Tried

__all__ = [
    "Equation4",
    "Equation5",
    "FixedWeight",
    "Needs",
    "RankCorrelation",
    "Rule",
    "SideBySide",
    "Signed",
    "Tried",
    "Trust",
    "TrustRule",
]

TrustRule = Equation4 | Equation5 | Signed | RankCorrelation | Tried | SideBySide | FixedWeight
"""Any rule; msgspec decodes it by its tag, the field "type"."""
