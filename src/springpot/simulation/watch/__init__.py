"""Observers of paths: distributions, spectra, first passage, a user's own functions."""
