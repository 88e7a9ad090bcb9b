"""A vehicle stands in nobody's light of the lamps and lasers that it carries, whoever else is there."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from pelagos.sim.simulation import Simulation

INSIDE = {"position_m": [0.0, 0.0, 0.0]}  # of the hull
LIGHTS: dict[str, dict[str, Any]] = {
    "lamp": {"lamps": [{**INSIDE, "orientation_deg": [0, 40, 0], "flux_lm": 3000}]},
    "line laser": {"lasers": [{**INSIDE, "orientation_deg": [0, 30, 0], "flux_lm": 3000, "fan_deg": 70}]},
}


def night(light: dict[str, Any], *, company: bool) -> Any:
    """Linear picture of the ground below, with or without another vehicle far off."""
    camera = {
        "type": "camera", "rate_hz": 10, "width_px": 64, "height_px": 48, "position_m": [0.3, 0, 0.1],
        "exposure": "manual", "shutter_s": 0.05, "iso": 1600, "tone": "linear", "bits": 16,
        "orientation_deg": [0, 30, 0], **light,
    }  # fmt: skip
    agents = {"rov": {"vehicle": "bluerov2", "start": {"position_m": [0, 0, -6]}, "sensors": {"camera": camera}}}
    if company:
        agents["other"] = {"vehicle": "bluerov2", "start": {"position_m": [-40, 0, -6]}}
    values = {"world": {"type": "flat", "depth_m": 8}, "ocean": {"sun": {"elevation_deg": -30}}, "agents": agents}
    return Simulation.load(values).reset()["rov"]["camera"].truth[0].astype(float)


@pytest.mark.parametrize("light", LIGHTS.values(), ids=list(LIGHTS))
def test_company_changes_no_light(light: dict[str, Any]) -> None:
    alone, together = night(light, company=False), night(light, company=True)
    assert alone.max() > 200
    assert np.abs(together - alone).max() <= 1 + 1e-3 * alone.max()
