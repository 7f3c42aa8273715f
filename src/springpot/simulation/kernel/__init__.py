"""Compiled code: the block of paths, its steps, random numbers, each part's law, its cache."""
