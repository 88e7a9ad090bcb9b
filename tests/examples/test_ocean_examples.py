"""The example with currents and temperature from NetCDF, and that the water carries the vehicle."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml

import pelagos as pl

ROOT = Path(__file__).parents[2]
pytest.importorskip("xarray")


@pytest.fixture(scope="module")
def scenario(tmp_path_factory) -> dict:
    target = tmp_path_factory.mktemp("ocean") / "circulation.nc"
    subprocess.run([sys.executable, str(ROOT / "examples/write_circulation.py"), str(target)], check=True)
    data = yaml.safe_load((ROOT / "examples/adriatic_currents.yaml").read_text())
    data["ocean"]["currents"]["file"] = str(target)
    data["ocean"]["temperature_c"][0]["file"] = str(target)
    return data


def test_the_eddy_carries_the_vehicle_and_warms_the_ctd(scenario: dict) -> None:
    """600 m south of the centre the eddy goes east with 0.35 x 0.5 e^(3/8) e^(-12/50) x 1.1 = 0.22 m/s; core + 1.56
    degC.
    """
    sim = pl.Simulation.load(scenario)
    obs = sim.reset()
    water = obs["auv0"]["current"].truth[0] + [1.5, 0, 0]
    assert -water[1] == pytest.approx(0.22, abs=0.02)
    level = [22 - 9 / (1 + np.exp((18 - z) / 3)) for z in (10, 15)]  # between which the file is linear
    assert obs["auv0"]["ctd"].truth[0, 1] == pytest.approx(np.interp(12, (10, 15), level) + 2 * np.exp(-0.25), abs=0.02)
    sim.run(seconds=20)
    x, y, _ = sim.state["auv0"].position[0]
    assert -y == pytest.approx(20 * 0.22, rel=0.3)
    still = pl.Simulation.load({**scenario, "ocean": {}})
    still.reset()
    still.run(seconds=20)
    assert abs(still.state["auv0"].position[0, 1]) < 0.3
    assert x > -590


def test_a_run_that_leaves_the_file_is_refused_before_it_starts(scenario: dict) -> None:
    far = {**scenario, "origin": {"latitude_deg": 44.9, "longitude_deg": 13.96}}
    with pytest.raises(pl.PelagosError, match="outside: clamp"):
        pl.Simulation.load(far)


@pytest.mark.slow
def test_wave_gallery(tmp_path: Path) -> None:
    subprocess.run([sys.executable, str(ROOT / "examples/wave_gallery.py"), str(tmp_path)], check=True)
    assert {p.name for p in tmp_path.iterdir()} == {"wave_usv.jpg", "wave_auv.jpg"}


def test_a_vehicle_that_leaves_the_file_is_told_so(scenario: dict, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)  # where the last states are written
    sim = pl.Simulation.load(scenario)
    sim.set_state("auv0", position=(7000.0, 0.0, -5.0))
    with pytest.raises(
        pl.PelagosError, match=r"the current of circulation.nc and the temperature of circulation.nc ends"
    ):
        sim.run(1.0)
