import importlib
from collections.abc import Iterator
from pathlib import Path

import pytest

sums = importlib.import_module("springpot.memory.exponential_sum")


@pytest.fixture
def fresh_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder for the sums, and none of them in memory."""
    monkeypatch.setenv("SPRINGPOT_CACHE_DIR", str(tmp_path / "cache"))
    sums._cached.cache_clear()
    return tmp_path / "cache" / "memory"


@pytest.fixture(autouse=True, scope="package")
def _own_folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Sums of these tests, and of no others, are made by the code under test, not found in the user's folder."""
    sums._cached.cache_clear()
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SPRINGPOT_CACHE_DIR", str(tmp_path_factory.mktemp("cache")))
        yield
