"""Other people's environments as games of this program, and its games as environments for theirs."""
