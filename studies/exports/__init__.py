"""What others can read of our data: one file per format. No screen."""
