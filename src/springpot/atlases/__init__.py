"""The atlas: a table of stationary moments by Monte Carlo, interpolated in microseconds, with errors."""

from springpot.atlases.lookup import AtlasAnswer, atlas

__all__ = ["AtlasAnswer", "atlas"]
