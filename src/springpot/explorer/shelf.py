"""The systems that a tab of the page may show: what it was opened with, some of several masses, and uploaded files."""

from __future__ import annotations

import hashlib
import threading
from collections.abc import Iterator

from springpot.explorer.question import Opened
from springpot.machine.plain import toml_of
from springpot.problem.file import read_system
from springpot.problem.free_numbers import uncertain_numbers
from springpot.problem.parts import Barrier, Contact, Dashpot, Mass, Spring, Springpot, WhiteNoise
from springpot.problem.system import System

MOST_FILES = 64  # that are kept; the oldest is forgotten


def pounding() -> System:
    """Two buildings of one storey on ground that shakes, 4 cm from each other.

    Examples
    --------
    >>> pounding().points
    ('tower', 'annex')
    """
    tower, annex, both = ("ground", "tower"), ("ground", "annex"), ("tower", "annex")
    return System(
        Mass(1.2e6, at="tower"), Mass(6e5, at="annex"),
        tower_frame=Spring(1.7e7, between=tower), tower_damper=Dashpot(2.7e5, between=tower),
        annex_frame=Spring(3.4e7, between=annex), annex_damper=Springpot(0.6, 6e5, between=annex),
        pounding=Contact(-0.04, 2e9, 1.5, 2.0, between=both), earthquake=WhiteNoise(0.02, on="ground"),
    )  # fmt: skip


def chain() -> System:
    """Four masses in a row between two walls, shaken at both ends, with a stop in the middle.

    Examples
    --------
    >>> list(chain().stops)
    ['left_wall', 'right_wall', 'stop']
    """
    ends = ("ground", "a"), ("a", "b"), ("b", "c"), ("c", "d"), ("ground", "d")
    springs = {f"spring_{n}": Spring(40.0, between=pair) for n, pair in enumerate(ends, start=1)}
    return System(
        *(Mass(0.1, at=point) for point in "abcd"), **springs,
        left_damper=Dashpot(0.1, between=ends[0]), mount=Springpot(0.5, 0.6, between=ends[2]),
        right_damper=Dashpot(0.1, between=ends[4]),
        left_wall=Barrier(-0.03, 0.8, between=ends[0]), right_wall=Barrier(0.03, 0.8, "below", between=ends[4]),
        stop=Barrier(-0.02, between=ends[2]), left_noise=WhiteNoise(4e-3, on="a"), right_noise=WhiteNoise(4e-3, on="d"),
    )  # fmt: skip


GALLERY = {
    "pounding": ("Two buildings that pound", pounding),
    "chain": ("A chain of four masses between walls", chain),
}


class Shelf:
    """Systems by their places in the address of the page; that of what it was opened with is empty.

    Parameters
    ----------
    opened : Opened

    Examples
    --------
    >>> shelf = Shelf(Opened())
    >>> place = shelf.put('[[parts]]\\nkind = "spring"\\nstiffness = 80.0', "device.toml")
    >>> shelf.at(place).system.stiffness, shelf.at("nowhere") == shelf.at("")
    (80.0, True)
    """

    def __init__(self, opened: Opened) -> None:
        self._own = {"": opened} | {place: Opened(make(), f"{place}.toml") for place, (_, make) in GALLERY.items()}
        self._files: dict[str, Opened] = {}
        self._adding = threading.Lock()

    def has(self, place: str) -> bool:
        """Whether there is a system."""
        return place in self._own or place in self._files

    def at(self, place: str) -> Opened:
        """The system of a place; what the page was opened with, if there is none."""
        return self._own.get(place) or self._files.get(place) or self._own[""]

    def put(self, text: str, name: str) -> str:
        """Keep the system of a TOML file; its place.

        Raises
        ------
        ValueError
            One sentence that says what is wrong in the file.
        """
        system = read_system(toml_of(text, f"system file {name!r}"))
        uncertain_numbers(system)  # those of one name are alike
        place = hashlib.sha256(f"{name}\n{text}".encode()).hexdigest()[:16]
        with self._adding:
            self._files[place] = Opened(system, name)
            while len(self._files) > MOST_FILES:
                del self._files[next(iter(self._files))]
        return place

    def listed(self) -> Iterator[tuple[str, str]]:
        """Place and name of the systems that are always there."""
        yield "", self._own[""].file or ("The paper's oscillator" if self._own[""] == Opened() else "As it was opened")
        yield from ((place, title) for place, (title, _) in GALLERY.items())
