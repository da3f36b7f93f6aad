"""What was found, in sentences for a reader."""
