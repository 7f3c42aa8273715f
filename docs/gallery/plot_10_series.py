"""
The paper's first figure
========================

The Fourier series of the modulus of a cosine, on which averaging is based, and its error.
"""

import matplotlib.pyplot as plt

import springpot as sp

figure, (above, below) = plt.subplots(2, figsize=(7.0, 6.0), sharex=True, height_ratios=(3, 2))
sp.figures.plot_fourier_series(above)
sp.figures.plot_fourier_error(below)
above.set_xlabel("")
plt.show()
