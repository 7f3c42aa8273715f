"""Pictures of results; matplotlib is imported only when a picture is asked for."""

from springpot.figures.style import COLOURS, new_figure, save

__all__ = ["COLOURS", "new_figure", "save"]
