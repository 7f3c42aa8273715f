"""Numerical tools that several methods share, independent of the oscillator."""
