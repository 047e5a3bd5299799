"""The program's Keepaway as a PettingZoo environment (extra `pettingzoo`)."""
