"""Names and units of the numbers a simulation estimates."""

__all__ = ["UNITS"]

UNITS = {
    "x_mean": "m",
    "x_mean_square": "m2",
    "v_mean_square": "m2 s-2",
    "amplitude_mean_square": "m2",
    "impact_rate": "s-1",
    "impact_speed_mean": "m s-1",
    "impact_speed_mean_square": "m2 s-2",
    "springpot_force_mean": "m s-2",
    "springpot_power": "m2 s-3",
    "springpot_virial": "m2 s-2",
    "energy_residual": "1",
    "x_mean_end": "m",
    "x_mean_square_end": "m2",
    "v_mean_square_end": "m2 s-2",
    "amplitude_mean_square_end": "m2",
}
"""Names and units of everything a run estimates; each has a twin ``_se``, its standard error, in the same unit.

``springpot_force_mean``, ``springpot_power`` and ``springpot_virial`` are C <D^a x>, C <v D^a x> and C <x D^a x>;
``energy_residual`` is what the noise is expected to feed in, less what springpot and wall took out and the motion
gained, over what was fed in; the ``_end`` values are averages over the paths at the end of the run.
"""
