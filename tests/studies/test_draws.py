"""Studies of devices that are drawn: the axis ``draw``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import springpot as sp
from springpot import cli
from springpot.machine.faults import FileError
from springpot.problem.free_numbers import with_values

GAP = sp.uncertain("gap", 0.002, cov=0.1)
DEVICE = sp.System(
    sp.Mass(0.2), sp.Spring(sp.uncertain("k", 80.0, cov=0.05, correlation={"c": 0.5})),
    sp.Dashpot(sp.uncertain("c", 0.4, cov=0.2)), sp.WhiteNoise(5e-5), lower=sp.Barrier(-GAP, 0.9),
    upper=sp.Barrier(1.5 * GAP, 0.9),
)  # fmt: skip
ASKED: dict[str, Any] = {
    "name": "devices", "seed": 3, "draws": 16, "system": DEVICE, "methods": ["linearization", "monte_carlo"],
    "quantities": ["x_mean_square"], "axes": {"parts.lower.restitution": [0.9, 0.8]},
    "monte_carlo": {"paths": 64, "duration": 2.0, "step": 1e-3, "start": "rest"},
}  # fmt: skip


@pytest.mark.validation  # every day: a file grows in its store, in this file
def test_the_devices_are_those_of_a_scatter() -> None:
    data = sp.study(ASKED)["simulation"].to_dataset()
    assert dict(data.sizes) == {"lower_restitution": 2, "draw": 16, "barrier": 2}
    linear = sp.System(*(part for part in DEVICE.parts if not isinstance(part, sp.Barrier)))
    own = {**ASKED, "system": linear, "axes": {}, "methods": ["linear"], "draws": 64}
    del own["monte_carlo"]
    tree = sp.study(own)["theory"].to_dataset()
    scattered = sp.scatter(linear, ["x_mean_square"], method="linear", devices=64, seed=3)
    np.testing.assert_array_equal(tree["spring_stiffness"], scattered.draws[:, 0])
    np.testing.assert_allclose(tree["x_mean_square"].sel(theory="linear"), scattered.means["x_mean_square"], rtol=1e-12)
    few = sp.study({**own, "draws": 16})["theory"].to_dataset()
    assert {*few["spring_stiffness"].values} < {*tree["spring_stiffness"].values}
    np.testing.assert_allclose(data["upper_position"], -1.5 * data["lower_position"])
    assert data["x_mean_square"].isel(draw=3, lower_restitution=0) > 0.0


def test_a_file_grows_in_its_store(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "device.toml").write_text(sp.to_toml(with_values(DEVICE, {"gap": 0.002})), encoding="utf-8")
    file = tmp_path / "study.toml"
    text = 'name = "a"\nsystem = "device.toml"\ndraws = 16\nmethods = ["envelope"]\n'
    file.write_text(text, encoding="utf-8")
    words = ["study", "run", str(file), "--store", str(tmp_path / "a.zarr")]
    assert cli.main(words) == 0
    file.write_text(text.replace("16", "32"), encoding="utf-8")
    assert cli.main(words) == 0
    capsys.readouterr()
    assert cli.main(["study", "status", str(tmp_path / "a.zarr")]) == 0
    assert "32" in capsys.readouterr().out
    new = tmp_path / "new.toml"
    assert cli.main(["study", "new", str(new), "--system", str(tmp_path / "device.toml")]) == 0
    assert "\ndraws = 64 " in new.read_text(encoding="utf-8")
    assert "uncertain(" not in new.read_text(encoding="utf-8")
    assert cli.main(["study", "check", str(new)]) == 0


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"draws": 10}, "draws must be a power of two from 16 to 65536, not 10."),
        ({"draws": True}, "draws must be a power of two from 16 to 65536, not True."),
        ({"draws": None}, "draws must be a power of two from 16 to 65536, for k, c and gap are uncertain."),
        ({"system": sp.nominal(DEVICE)}, "draws are of uncertain numbers, and the system has none."),
        ({"system": None}, "draws are of a system's uncertain numbers: name its file as system."),
        ({"zipped": {"draw": {"parts.mass.value": [0.2]}}}, "zipped axis 'draw' must have another name beside draws."),
        ({"axes": {"parts.spring.stiffness": [80.0]}}, "parts.spring.stiffness is on two axes"),
        ({"seed": -1}, "seed"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_one_sentence(change: dict[str, Any], words: str) -> None:
    content = {name: value for name, value in (ASKED | change).items() if value is not None}
    with pytest.raises(FileError) as caught:
        sp.study(content)
    assert words in str(caught.value)
