r"""
A power law as a sum of exponentials
====================================

A fractional derivative depends on the whole history, with the weight :math:`t^{-\alpha}`. For an exponential weight
one number stores the whole history, however long. A sum of a few exponentials approximates the power law as closely
as needed.
"""

import matplotlib.pyplot as plt

import springpot as sp

figure, (left, right) = plt.subplots(1, 2, figsize=(10.0, 4.2))
sp.figures.plot_memory_terms(0.5, left, tolerance=1e-2)
sp.figures.plot_memory_error(0.5, right)
plt.show()

# %%
# The error reaches its largest size many times, with alternating signs: so no shorter sum has a smaller error. The
# next figure shows how many terms are needed for six decades of time, against the error:

figure, axes = plt.subplots(figsize=(6.6, 4.4))
sp.figures.plot_terms_against_tolerance(axes)
plt.show()
