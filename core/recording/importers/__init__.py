"""Turn other programs' logs into our recordings."""
