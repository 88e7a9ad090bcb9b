"""The example of the live view runs with its page served, and the sea that it sets is felt."""

from __future__ import annotations

import runpy
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[2] / "examples"
pytest.importorskip("websockets", reason="the test needs websockets")


@pytest.mark.slow
def test_the_sea_rises_under_the_boat(capsys: pytest.CaptureFixture[str]) -> None:
    """0.4 m of significant height, then 1 m: the boat, 5 m long, follows waves of 39 m and more."""
    heaves = runpy.run_path(str(EXAMPLES / "live_view.py"))["main"](20.0)
    assert capsys.readouterr().out.startswith("http://127.0.0.1:")
    assert len(heaves) == 2
    assert heaves[1] > 1.3 * heaves[0] > 0.1
