"""Recordings: schema, writer, reader, verification, importers."""
