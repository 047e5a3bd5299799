"""Other people's environments as games of this program."""
