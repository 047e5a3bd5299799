"""Domains, learners, human feedback, their combination, recording and replay. No screen, no printing."""
