"""How often the screen is drawn at most. Nothing is imported here: it is set before Textual is imported."""

FRAMES_PER_S = "30"
"""Upper bound of Textual's drawing rate: the value of the variable TEXTUAL_FPS."""
FRAME_S = 1 / int(FRAMES_PER_S)
"""Duration of a frame at that rate, seconds."""
