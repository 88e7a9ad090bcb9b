"""HoloOcean's documented examples, written anew, as their users run them."""

import subprocess
import sys
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[2] / "examples" / "holoocean"


def said(name: str, *arguments: str) -> str:
    """What a script prints under `pelagos holoocean`."""
    command = [sys.executable, "-m", "pelagos", "holoocean", "--seed", "0", str(FOLDER / name), *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.slow
def test_a_sonar_sees_the_pier(tmp_path):
    assert said("sonar_imaging.py", str(tmp_path / "sonar.png")).startswith("(256, 256) from")
    assert (tmp_path / "sonar.png").stat().st_size > 10_000


@pytest.mark.slow
def test_a_torpedo_comes_to_its_depth_and_heading():
    words = said("fossen.py").split()
    assert abs(float(words[1]) - 15) < 1
    assert abs(float(words[4]) - 50) < 10


@pytest.mark.slow
def test_a_camera_sees_the_dam(tmp_path):
    assert said("camera.py", str(tmp_path / "left.png")).startswith("(512, 512, 4)")


@pytest.mark.slow
def test_the_smaller_scripts_say_what_they_should(tmp_path):
    assert "IMUSensor" in said("getting_started.py")
    assert said("acoustic_messages.py").startswith("tick 13: ['OWAY', 0, 'my data payload']")
    assert said("optical_messages.py").split() == ["Message", "None"]
    assert "3 labels" in said("depth_and_labels.py", str(tmp_path / "a.png"))
    reached, speed = (float(word) for word in said("custom_dynamics.py").split() if word[0] == "1")
    assert 0.9 * speed < reached < speed


@pytest.mark.slow
def test_a_torpedo_and_an_otter_go_by_fossens_equations():
    torpedo, otter = said("fossen_fleet.py").splitlines()
    assert 1.0 < float(torpedo.split()[1]) < 2.5
    assert 1.5 < float(otter.split()[1]) < 3.0


@pytest.mark.slow
def test_a_torpedo_passes_its_waypoints(tmp_path):
    lines = said("fossen_waypoints.py", str(tmp_path / "way.png")).splitlines()
    assert [line.split()[1] for line in lines] == ["0", "1", "2"]


@pytest.mark.slow
def test_sonars_that_look_down_find_the_ground(tmp_path):
    profile = said("sonar_profiling.py", str(tmp_path / "profile.png"))
    assert 4 < float(profile.split()[5]) < 8
    beam = said("sonar_singlebeam.py", str(tmp_path / "beam.png"))
    assert 12 < float(beam.split()[6]) < 20
