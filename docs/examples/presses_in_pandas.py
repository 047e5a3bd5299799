"""Analyse presses by participant, condition and game: python presses_in_pandas.py TABLES."""

import sys
from pathlib import Path

import pandas as pd

tables = Path(sys.argv[1])
presses = pd.read_csv(tables / "presses.csv")
games = pd.read_csv(tables / "games.csv")

# How often do participants press in each game, and how much of it is praise?
counted = presses[presses.counted]
print(counted.groupby(["participant", "condition", "game"], dropna=False).value.agg(["size", "mean"]))

# How long after a step comes into view do they press?
print(counted.groupby(["participant", "domain"]).since_shown_s.describe()[["count", "50%"]])

# Do games with more presses go better? (Unseen games have no number.)
print(games[games.watched].groupby("domain")[["presses_counted", "performance"]].corr(method="spearman"))
