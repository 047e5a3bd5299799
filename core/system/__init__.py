"""Files, processes and other people's text: what the operating system and strangers' files ask for."""
