"""A part that adds to the inertia, as a user may write it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

import pytest

from springpot.problem.parts.registration import Number, Part
from springpot.problem.system import KINDS

__all__ = ["inerter"]


def inerter(monkeypatch: pytest.MonkeyPatch) -> Any:
    """The class, which is registered until the end of a test."""
    monkeypatch.setattr(Part, "kinds", dict(Part.kinds))

    @dataclass(frozen=True)
    class Inerter(Part):
        said, glyph, powers = "inerter", "mass", ("inertia",)
        is_linear, remembers, dissipates, is_thermal, is_odd = True, False, False, True, True

        inertance: Annotated[float, Number("b", "inertance", "kg")]

        @property
        def inertia(self) -> float:
            return self.inertance

        def term(self) -> str:
            return f" + {self.inertance:g} x''"

    monkeypatch.setitem(KINDS, "inerter", Inerter)
    return Inerter
