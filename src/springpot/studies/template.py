"""The study file that `springpot study new` writes."""

from springpot.theory.registry import METHODS

__all__ = ["TEMPLATE"]

TEMPLATE = """\
# A study: a grid of oscillators, each computed by every method below.  It takes ten seconds.
#     springpot study check {file}
#     springpot study run {file} --store {store}
#     springpot study plot {store} --out {picture}
#     springpot study export {store} {table}
name = {name}
seed = 1             # every point's own seed is made from this and the point's numbers
# methods: METHODS
methods = [
    "averaging",
    "envelope",
    "monte_carlo",
]
# amplitude_mean_square, x_mean, x_mean_square, v_mean_square, impact_rate, impact_speed_mean, impact_speed_mean_square
quantities = ["amplitude_mean_square", "impact_rate"]  # what rtol controls and charts show; the store keeps them all

[fixed]              # the same at every point; these values are also the defaults
coefficient = 1.0    # C, s^(alpha-2)
natural_frequency = 1.0  # Omega, rad/s
intensity = 1.0      # q, m^2/s^3
position = 0.0       # b, m
side = "above"       # of the wall, where the mass moves
barrier = true       # false: no wall

[axes]               # the grid is the product of the axes; they can be extended later
order = {{linspace = [0.2, 1.0, 9]}}      # start, end, count; or geomspace = [start, end, count]
restitution = [1.0, 0.9, 0.7]            # or a plain list

# [zipped.case]      # columns that vary together, along one axis with a name of your own
# coefficient = [0.1, 0.5]
# natural_frequency = [1.0, 2.0]

[monte_carlo]        # one of
rtol = 0.03          #   the total relative error of the quantities,
# path_times = 1e5   #   the same effort at every point (0.4 / sqrt(path_times) is the relative error of <A^2>), or
# paths = 5000       #   the settings of a run: paths, duration, step, window, scheme, start = "rest", ...
""".replace("METHODS", ", ".join((*METHODS, "monte_carlo")))
