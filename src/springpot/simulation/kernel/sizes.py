"""Sizes of a block of paths, known without Numba."""

LANES = 64  # paths of a block, advanced together
GROUP = 4  # steps between two updates of the memory modes; one Philox block gives four normals
MOST_MODES = 384  # of the memory of a path


def middle_of(low: int, high: int) -> int:
    """The step at the middle of a window, at the end of a group."""
    return (low + high) // (2 * GROUP) * GROUP
