"""The terminal app: shows and asks, never computes."""
