import importlib
from pathlib import Path

import pytest

sums = importlib.import_module("springpot.memory.exponential_sum")


@pytest.fixture
def fresh_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder for the sums, and none of them in memory."""
    monkeypatch.setenv("SPRINGPOT_CACHE_DIR", str(tmp_path / "cache"))
    sums._kept.cache_clear()
    return tmp_path / "cache" / "memory"
