"""One command, one file: what `arl` does, and how it tells the result."""
