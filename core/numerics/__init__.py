"""Arrays, random streams, clocks and compiled kernels: what has no meaning of its own in a study."""
