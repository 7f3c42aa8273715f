"""What is tested every day, and what only ``make validate`` tests."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import pytest

__all__ = ["thinned", "validation"]


def validation(*values: Any) -> Any:
    """Arguments of a parametrized test that take too long for every day; others of the test run every day."""
    return pytest.param(*values, marks=pytest.mark.validation)


def thinned(cases: Iterable[Any], every: int) -> list[Any]:
    """Cases of a parametrized test: one in so many, from the first, every day, and the others in ``make validate``."""
    own = [case if isinstance(case, tuple) else (case,) for case in cases]
    return [pytest.param(*case) if i % every == 0 else validation(*case) for i, case in enumerate(own)]
