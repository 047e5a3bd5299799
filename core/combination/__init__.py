"""How environmental and human feedback become one choice (Eqs. 2-5 of the paper)."""
