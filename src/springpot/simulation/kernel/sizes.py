"""Sizes of a block of paths, known without Numba."""

LANES = 64  # paths of a block, advanced together
GROUP = 4  # steps between two updates of the memory modes; one Philox block gives four normals
