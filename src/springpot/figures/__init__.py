"""Pictures of results; matplotlib is imported only when a picture is drawn.

A function draws into the given axes, ``ax``, or into those of a new figure without a window and without global state,
and returns them.  Those that need several panels have no ``ax``, and return a figure.  Axes have units, colors are safe
for color-blind readers, and bars are 95 % intervals.
"""

from springpot.figures.approximations import (
    plot_convergence,
    plot_fourier_error,
    plot_fourier_series,
    plot_memory_error,
    plot_memory_terms,
    plot_terms_against_tolerance,
)
from springpot.figures.charts import plot_design_chart
from springpot.figures.designing import plot_design_curve, plot_scatter, plot_sensitivities
from springpot.figures.fits import plot_fit, plot_profile
from springpot.figures.motion import plot_path, plot_phase_portrait
from springpot.figures.passages import plot_passage_probability, plot_rainflow, plot_return_periods
from springpot.figures.spectra import plot_fragility, plot_response_spectrum
from springpot.figures.stationary import plot_comparison, plot_correlation, plot_density, plot_spectrum
from springpot.figures.studies import plot_study
from springpot.figures.style import COLORS, METHOD_LINES, bars, new_figure, new_grid, save, with_common_words
from springpot.figures.sweeps import plot_against
from springpot.figures.transients import plot_over_time, plot_survival, plot_transient
from springpot.figures.validity import plot_gaps, plot_gaps_of_methods, plot_system_gaps, plot_system_gaps_of_methods
from springpot.machine.installed import need

need("plots", "a picture")

__all__ = [
    "COLORS",
    "METHOD_LINES",
    "bars",
    "new_figure",
    "new_grid",
    "plot_against",
    "plot_comparison",
    "plot_convergence",
    "plot_correlation",
    "plot_density",
    "plot_design_chart",
    "plot_design_curve",
    "plot_fit",
    "plot_fourier_error",
    "plot_fourier_series",
    "plot_fragility",
    "plot_gaps",
    "plot_gaps_of_methods",
    "plot_memory_error",
    "plot_memory_terms",
    "plot_over_time",
    "plot_passage_probability",
    "plot_path",
    "plot_phase_portrait",
    "plot_profile",
    "plot_rainflow",
    "plot_response_spectrum",
    "plot_return_periods",
    "plot_scatter",
    "plot_sensitivities",
    "plot_spectrum",
    "plot_study",
    "plot_survival",
    "plot_system_gaps",
    "plot_system_gaps_of_methods",
    "plot_terms_against_tolerance",
    "plot_transient",
    "save",
]  # fmt: skip

for _name in __all__:
    if _name.startswith("plot_"):
        with_common_words(globals()[_name])
