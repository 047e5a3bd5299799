"""The screens of the reaction-time study: what a participant sees and presses while being measured."""
