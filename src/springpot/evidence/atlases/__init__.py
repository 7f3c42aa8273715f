"""The atlas: a table of stationary moments by Monte Carlo, interpolated in microseconds, with errors."""

from springpot.evidence.atlases.lookup import AtlasAnswer, atlas

__all__ = ["AtlasAnswer", "atlas"]
