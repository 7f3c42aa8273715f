r"""
The erratum that matters
========================

Eq. 14 loses a factor :math:`\Omega`, and so Eq. 20 is printed with an error. At :math:`\Omega = 1`, the only case
in the paper, this has no effect. Elsewhere the printed formula is too large by the factor :math:`\Omega`. Monte
Carlo confirms the corrected formula.
"""

import textwrap

import matplotlib.pyplot as plt
import numpy as np

import springpot as sp
from springpot.paper.errata import ERRATA


def tuned(frequency):
    return sp.Oscillator(frequency, sp.Springpot(order=0.7, coefficient=0.2))


figure, axes = plt.subplots(figsize=(6.4, 4.4))
sp.figures.plot_against(
    "natural_frequency", axes, system=tuned(1.0), values=np.geomspace(0.3, 3.0, 61),
    theory={
        "Eq. 20 as printed": lambda oscillator: sp.theory.averaging(oscillator, form="printed"),
        "Eq. 20 corrected": sp.theory.averaging,
    },
    runs=[sp.simulate(tuned(frequency), rtol=0.01) for frequency in np.geomspace(0.3, 3.0, 8)],
    label="Monte Carlo (bars are smaller than marks)",
)  # fmt: skip
axes.set(xscale="log", yscale="log")
axes.minorticks_off()
axes.set_xticks([0.3, 0.5, 1.0, 2.0, 3.0], ["0.3", "0.5", "1", "2", "3"])
axes.set_yticks([1.0, 3.0, 10.0, 30.0], ["1", "3", "10", "30"])
axes.legend(frameon=False)
plt.show()

# %%
# The other errors
# ----------------
#
# Each of the seven errors has a check. It computes the number in question without the equation that is wrong.

for slip in ERRATA:
    print(f"{slip.number}. {slip.equation}: {slip.title}.")
    for finding in slip.check()[:2]:
        print(
            f"     {textwrap.shorten(finding.what, 60):60s} computed {finding.computed:8.4f}, "
            f"printed {finding.printed:8.4f}, right {finding.corrected:8.4f}"
        )
