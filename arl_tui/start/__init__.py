"""The page of `arl` without a command: what one can do, and how each is said on the command line."""
