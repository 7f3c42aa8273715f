"""The result of a run, its warnings, its file."""
