"""The whole stationary response of the oscillator, computed once: answers in microseconds, with their error."""

from springpot.atlases.lookup import AtlasAnswer, atlas

__all__ = ["AtlasAnswer", "atlas"]
