"""Settings as frozen structs: their ranges, a catalogue of them, and strict reading from plain types."""
