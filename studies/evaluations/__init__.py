"""Evaluations of an agent from elsewhere: presses with values and times, without the states they judge."""
