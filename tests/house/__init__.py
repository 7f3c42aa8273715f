"""Facts about the house that a sentence in its rules claims, measured from the code."""
