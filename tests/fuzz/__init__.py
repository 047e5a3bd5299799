"""Fuzzers: whatever bytes come, a reader gives its documented error, soon, and in bounded memory."""
