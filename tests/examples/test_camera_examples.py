"""Examples of the cameras that are quick enough to be run in every test."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]


def test_daylight_depth(tmp_path: Path) -> None:
    """A picture, and a table that says that Kd of all ten types is kept."""
    picture = tmp_path / "depth.png"
    command = [sys.executable, str(ROOT / "examples/daylight_depth.py"), str(picture)]
    said = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    assert picture.stat().st_size > 20_000
    rows = [line.split() for line in said.splitlines()[2:]]
    assert len(rows) == 10
    assert all(abs(float(v) - 1) < 0.005 for row in rows for v in row[1:4])
