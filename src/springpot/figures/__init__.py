"""Pictures of results; matplotlib is imported only when a picture is drawn.

A function draws into the given ``axes``, or into those of a new figure without a window and without global state, and
returns them.  Functions with several panels begin with ``draw_`` and return a figure.  Axes have units, colors are
safe for color-blind readers, and bars are 95 % intervals.
"""

from springpot.figures.charts import design_chart
from springpot.figures.comparison import draw_comparison
from springpot.figures.convergence import convergence
from springpot.figures.designing import design_curve, draw_sensitivities
from springpot.figures.fits import draw_fit, profile
from springpot.figures.from_rest import survival, transient
from springpot.figures.memory import memory_error, memory_terms, terms_against_tolerance
from springpot.figures.motion import path, phase_portrait
from springpot.figures.series import fourier_error, fourier_series
from springpot.figures.stationary import correlation, density, spectrum
from springpot.figures.studies import draw_study
from springpot.figures.style import COLORS, METHOD_LINES, bars, new_figure, new_grid, save
from springpot.figures.sweeps import against
from springpot.figures.validity import draw_gaps, draw_system_gaps, gaps, system_gaps

__all__ = [
    "COLORS", "METHOD_LINES", "against", "bars", "convergence", "correlation", "density", "design_chart",
    "design_curve", "draw_comparison", "draw_fit", "draw_gaps", "draw_sensitivities", "draw_study",
    "draw_system_gaps", "fourier_error", "fourier_series", "gaps", "memory_error", "memory_terms", "new_figure",
    "new_grid", "path", "phase_portrait", "profile", "save", "spectrum", "survival", "system_gaps",
    "terms_against_tolerance", "transient",
]  # fmt: skip
