"""What is tested every day, and what only ``make validate`` tests."""

from __future__ import annotations

from typing import Any

import pytest

__all__ = ["validation"]


def validation(*values: Any) -> Any:
    """Arguments of a parametrized test that take too long for every day; others of the test run every day."""
    return pytest.param(*values, marks=pytest.mark.validation)
