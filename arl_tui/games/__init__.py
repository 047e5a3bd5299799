"""What the app knows of each game: rendering and panels."""
