"""A recorded session, to be looked at: index, timeline, credit of a press, values at each decision, comparison."""
