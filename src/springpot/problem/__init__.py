"""What a user states: parts, the system that is their sum, its file, its numbers and results by name."""
