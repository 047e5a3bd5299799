"""Human feedback: where it comes from and which steps it is about."""
