"""Equal seeds: the same system is the same to the last bit, unlike systems are off independently where that matters."""

import numpy as np
import pytest

import springpot as sp
from springpot.evidence import comparison, validity
from springpot.evidence.cells import PaperCell
from springpot.simulation.plan.options import own_seed
from springpot.studies.question import read_study
from springpot.studies.tasks import tasks


def _seeds_taken(monkeypatch: pytest.MonkeyPatch, module: object, name: str) -> list[int]:
    """The seeds with which a module simulates, instead of its runs."""
    taken: list[int] = []

    def noted(*_: object, seed: int, **__: object) -> None:
        taken.append(seed)
        raise InterruptedError

    monkeypatch.setattr(module, name, noted)
    return taken


def test_a_seed_of_its_own_depends_on_seed_and_thing() -> None:
    seeds = {own_seed(seed, {"order": order}) for seed in range(30) for order in np.linspace(0.1, 1.0, 30)}
    assert len(seeds) == 900
    assert own_seed(1, {"a": 1.0, "b": 2.0}) == own_seed(1, {"b": 2.0, "a": 1.0})
    assert all(0 <= seed < 2**63 for seed in seeds)


def test_comparisons_of_unlike_systems_have_unlike_seeds(monkeypatch: pytest.MonkeyPatch) -> None:
    taken = _seeds_taken(monkeypatch, comparison, "simulated")
    for frequency in (1.0, 2.0, 1.0):
        for simulate in (comparison.compare, comparison.observe):
            with pytest.raises(InterruptedError):
                simulate(sp.Oscillator(frequency, sp.Springpot(1.0, 1.0)), seed=3)
    assert taken[0] == taken[4] == own_seed(3, sp.Oscillator(1.0, sp.Springpot(1.0, 1.0)).to_dict())
    assert len(set(taken)) == 2
    with pytest.raises(ValueError, match="seed must be in"):
        comparison.compare(sp.Oscillator(springpot=sp.Springpot(1.0, 1.0)), seed=-1)


def test_cells_of_the_map_have_seeds_by_the_same_rule(monkeypatch: pytest.MonkeyPatch) -> None:
    taken = _seeds_taken(monkeypatch, validity, "simulated")
    for cell in (PaperCell(0.5, 1.0, 1.0, 0.0), PaperCell(0.5, 1.0, 0.8, 0.0)):
        with pytest.raises(InterruptedError):
            validity.simulate_cell(cell)
    named = {"order": 0.5, "c": 1.0, "restitution": 1.0, "position": 0.0}
    assert taken == [own_seed(7, named), own_seed(7, named | {"restitution": 0.8})]


def test_studies_keep_their_seeds() -> None:
    asked = {"name": "orders", "methods": ["monte_carlo"], "axes": {"order": [0.25, 0.5]}, "seed": 5}
    study = read_study({**asked, "monte_carlo": {"paths": 64}})
    assert [task.seed for task in tasks(study)] == KEPT


KEPT = [8574634355124237696, 7508080127747926026]
"""Of stores that were made before; with others a point would be simulated twice."""
