r"""
A power law as a sum of exponentials
====================================

A fractional derivative remembers its whole past with the weight :math:`t^{-\alpha}`. An exponential needs one
number to be carried on, whatever the length of the past; and a power law is a sum of a few exponentials, as closely
as one likes.
"""

import matplotlib.pyplot as plt

import springpot as sp

figure, (left, right) = plt.subplots(1, 2, figsize=(10.0, 4.2))
sp.figures.memory_terms(0.5, left, tolerance=1e-2)
sp.figures.memory_error(0.5, right)
plt.show()

# %%
# The largest error is reached again and again, with changing sign: this is the shortest sum there is. How many
# terms six decades of time need, against the error:

figure, axes = plt.subplots(figsize=(6.6, 4.4))
sp.figures.terms_against_tolerance(axes)
plt.show()
