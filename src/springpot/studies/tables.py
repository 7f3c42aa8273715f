"""The tables of a study file, what its JSON schema says of them, and the sentence of an error in it."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    InstanceOf,
    PlainSerializer,
    ValidationError,
    WithJsonSchema,
    create_model,
    model_validator,
)

from springpot.machine.faults import listed, meant, shown
from springpot.problem.basquin import Basquin
from springpot.problem.system import System
from springpot.simulation.plan.options import hints
from springpot.studies.axes import Axis
from springpot.theory.registry import METHODS

SIMULATED = ("monte_carlo", "exceedance")
"""Methods with random numbers; each has a table of its settings in the file."""

if TYPE_CHECKING:
    Method = str
else:
    Method = Literal[(*METHODS, *SIMULATED)]
PARAMETERS: Mapping[str, tuple[str, int]] = {
    "order": ("parts.springpot.order", 1), "coefficient": ("parts.springpot.coefficient", 1),
    "natural_frequency": ("parts.spring.stiffness", 2), "intensity": ("parts.white_noise.intensity", 1),
    "position": ("parts.barrier.position", 1), "restitution": ("parts.barrier.restitution", 1),
}  # fmt: skip
"""The paper's numbers by their short names: each the number of a part of which it is the root of this power."""


class Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, strict=True)


class _Given(Strict):
    """A table of settings, of which some may be left out."""

    def given(self) -> dict[str, Any]:
        """Those in the file."""
        return {name: value for name, value in self.model_dump().items() if value is not None}


class Fixed(Strict):
    """Parameters with the same value at every point; an axis must not have the same name."""

    order: float = 0.5
    coefficient: float = 1.0
    natural_frequency: float = 1.0
    intensity: float = 1.0
    position: float = 0.0
    restitution: float = 1.0
    free_side: Literal["above", "below"] = "above"
    barrier: bool = True


_Settings = create_model(  # a study has a seed of its own, and stores no paths
    "_Settings",
    __base__=_Given,
    **{
        name: (Annotated[hint, Field(strict=False)] if name == "window" else hint, None)
        for name, hint in hints("seed", "threads", "record", "record_every").items()
    },
)  # type: ignore[call-overload]


Device = Annotated[
    InstanceOf[System],
    PlainSerializer(System.to_dict),
    WithJsonSchema(
        {
            "anyOf": [{"type": "string"}, {"type": "object", "required": ["parts"]}],
            "description": "A system's file, its place relative to this one; or the same content (system.schema.json). "
            "Axes are then its numbers, parts.<name>.<number>.",
        }
    ),
]


def of_either(schema: dict[str, Any]) -> None:
    """What a study may say that names a system, and one that does not."""
    axes, zipped = schema["properties"]["axes"], schema["properties"]["zipped"]
    axes["properties"] = {"parts": {"type": "object"}}  # parts.stop.position = [...] is tables in tables
    zipped["additionalProperties"]["properties"] = {"parts": {"type": "object"}}
    schema["properties"]["draws"] = {
        "type": "integer", "minimum": 16,
        "description": "Of a system with uncertain numbers: how many devices are drawn, a power of two; the axis draw.",
    }  # fmt: skip
    own: dict[str, Any] = {"propertyNames": {"enum": [*PARAMETERS]}}
    theirs: dict[str, Any] = {"propertyNames": {"pattern": "^parts(\\.|$)"}}
    schema["if"] = {"required": ["system"]}
    schema["then"] = {"properties": {"axes": theirs, "zipped": {"additionalProperties": theirs}, "fixed": False}}
    schema["else"] = {"properties": {"axes": own, "zipped": {"additionalProperties": own}}}


class Curve(Strict):
    """The numbers of a `springpot.Basquin` curve."""

    exponent: float
    strength: float = 1.0
    cycles: float = 1.0
    stress: float = 1.0

    @model_validator(mode="after")
    def _possible(self) -> Curve:
        Basquin(**self.model_dump())
        return self


def _each_once(given: dict[str, tuple[float, ...]]) -> dict[str, tuple[float, ...]]:
    for name, levels in given.items():
        if len(set(levels)) < len(levels):
            raise ValueError(f"{name} holds a level twice")
    return given


Levels = Annotated[dict[str, Axis], Field(min_length=1), AfterValidator(_each_once)]


class MonteCarlo(_Settings):  # type: ignore[misc, valid-type]
    """How Monte Carlo is run: ``rtol``, or the settings of a run.

    ``rtol`` is the total relative error wanted of the study's quantities.  ``forces`` are forces and accelerations
    whose mean and mean square are wanted (linear theory has them too), ``rainflow`` displacements and forces whose
    cycles are counted, ``first_passage`` levels whose first passages are, and ``slowest_counted_impact`` is the speed
    from which impacts are.  All others are the arguments of `springpot.simulate`; without ``start`` and an initial
    state, the start is stationary.
    """

    rtol: float | None = Field(None, ge=1e-4, le=0.5)
    forces: Annotated[tuple[str, ...] | None, Field(strict=False)] = None
    rainflow: dict[str, Curve] | None = None
    first_passage: Levels | None = None
    slowest_counted_impact: float | None = Field(None, ge=0.0)

    @model_validator(mode="after")
    def _one_way(self) -> MonteCarlo:
        given = self.given()
        if not given:
            raise ValueError("say how: rtol = 0.02, or settings such as paths and duration")
        if "rtol" in given and len(given) > 1:
            other = next(name for name in given if name != "rtol")
            raise ValueError(f"rtol chooses all settings, so {other} cannot be given with it")
        return self


_OfPaths = create_model(
    "_OfPaths",
    __base__=_Given,
    **{
        name: (hint, None)
        for name, hint in hints().items()
        if name in ("step", "start", "initial_position", "initial_velocity", "memory_tolerance")
    },
)  # type: ignore[call-overload]


class Exceeding(_OfPaths):  # type: ignore[misc, valid-type]
    """What is asked of rare events, and how: the arguments of `springpot.exceedance`."""

    levels: Levels
    duration: float = Field(gt=0.0)
    rtol: float | None = Field(None, ge=0.01, le=1.0)
    max_time: float | None = Field(None, gt=0.0)


_WORDS = (
    ("Input should be ", "must be "),
    (r"a valid dictionary( or instance of \w+)?", "a table"),
    ("a valid integer", "a whole number"),
    ("a valid number", "a number"),
    ("a valid string", "a text in quotes"),
    ("a valid tuple", "a list"),
    ("String should have at least 1 character", "must not be empty"),
    ("Tuple should have at least 1 item after validation, not 0", "must not be empty"),
    ("String should have", "must have"),
    ("Tuple should have", "must have"),
    (" after validation", ""),
)
"""Pydantic's words, and the words for the user of a TOML file."""


def unknown_key(key: object, table: str, known: Iterable[str]) -> str:
    """The sentence for a key that a table (``""``: the file itself) does not have."""
    names = [*known]
    where = f"[{table}]" if table else "a study file"
    return f"{shown(key)} is not a key of {where}{meant(str(key), names) or f': its keys are {listed(names)}.'}"


def sentence(error: ValidationError) -> str:
    """The sentence for the first error that pydantic reports."""
    fault = error.errors(include_url=False)[0]
    place = _place(fault["loc"])
    if fault["type"] == "missing":
        return f"{place} is missing."
    text = str(fault.get("ctx", {}).get("error", ""))
    if not text:
        text = str(fault["msg"])
        for theirs, ours in _WORDS:
            text = re.sub(theirs, ours, text)
        if text.startswith("must be") and isinstance(fault["input"], str | int | float):
            text += f", not {shown(fault['input'])}"
            if fault["type"] == "literal_error" and isinstance(fault["input"], str):
                text += meant(fault["input"], re.findall(r"'(\w+)'", str(fault["ctx"]["expected"])))
    text = text if text.endswith((".", "?")) else f"{text}."
    return f"{place}: {text}" if place else text


def _place(parts: tuple[str | int, ...]) -> str:
    """``methods, number 2`` for the second of a list, ``fixed.order`` for the key of a table."""
    keys = ".".join(part for part in parts if isinstance(part, str))
    numbers = [f"number {part + 1}" for part in parts if isinstance(part, int)]
    return ", ".join([keys, *numbers] if keys else numbers)
