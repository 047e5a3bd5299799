"""The app's process: driver, time stamps, the link to the learner's process, and the live session."""
