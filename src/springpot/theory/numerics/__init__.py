"""Numerical tools that several methods share; they know no oscillator."""
