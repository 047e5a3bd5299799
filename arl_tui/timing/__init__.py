"""The self-test of reaction times: a robot participant at the other end of a pseudo-terminal."""
