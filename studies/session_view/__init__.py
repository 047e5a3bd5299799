"""A recorded session, to be looked at: index, credit of a press, values of each decision, comparison."""
