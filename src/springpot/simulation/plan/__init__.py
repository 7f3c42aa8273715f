"""A system and options become settings, scales and a start, before anything is simulated."""
