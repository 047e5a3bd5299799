"""A session: its protocol, its run in one deterministic order, exact replay and what-ifs."""
