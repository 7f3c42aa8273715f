"""The published numbers of the documentation, each within its own digits or the deviation that the page explains."""

import runpy
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[1] / "docs"
NUMBERS = runpy.run_path(str(DOCS / "published_numbers.py"))


@pytest.mark.parametrize("source", NUMBERS["SOURCES"], ids=lambda source: source.__name__)
@pytest.mark.filterwarnings("ignore::springpot.SpringpotWarning")
def test_published_numbers(source) -> None:  # type: ignore[no-untyped-def]
    NUMBERS["show"](source())


def test_each_source_is_on_the_page() -> None:
    page = (DOCS / "published.md").read_text(encoding="utf-8")
    assert [
        each.__name__ for each in NUMBERS["SOURCES"] if f"numbers.show(numbers.{each.__name__}())" not in page
    ] == []


def test_a_number_that_differs_is_an_error(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(AssertionError):
        NUMBERS["show"]([NUMBERS["Row"]("order", 0.441, 0.443, 0.001)])
    assert "+4.5e-03" in capsys.readouterr().out
