"""Rules of trust: how far the human is trusted (section 3.1, Eqs. 4 and 5)."""
