"""Pictures of the sea: a WAM-V in sea states 2, 4 and 6, seen from a boat abeam and from its own deck, and the surface
from an AUV 2 m below it.

python examples/wave_gallery.py [FOLDER]
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

import pelagos as pl

SIZE = {"width_px": 480, "height_px": 300, "samples": 8, "rate_hz": 0.5, "type": "camera"}
PIXELS = (300, 480, 3)


def agent(vehicle: str, place: tuple[float, float, float], heading: float, camera: dict[str, Any]) -> dict[str, Any]:
    """A vehicle that drifts, and its camera."""
    start = {"position_m": list(place[:2]), "depth_m": place[2], "heading_deg": heading}
    return {"vehicle": vehicle, "control": "actuators", "start": start, "sensors": {"eye": {**SIZE, **camera}}}


def shoot(state: int, agents: dict[str, Any], seconds: float, **ocean: Any) -> dict[str, np.ndarray]:
    """The last picture of each agent."""
    sim = pl.Simulation.load(
        {
            "seed": 4,
            "tick_rate_hz": 100,
            "world": {"type": "flat", "depth_m": 60.0},
            "ocean": {
                "waves": {"type": "sea_state", "state": state, "towards_deg": 60},
                "water_type": "IB",
                "sun": {"elevation_deg": 40, "azimuth_deg": 250},
                **ocean,
            },
            "agents": agents,
        }
    )
    sim.run(seconds - 0.01)
    readings = sim.step()
    return {name: np.asarray(readings[name]["eye"].data).reshape(*PIXELS) for name in agents}


def main() -> None:
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "wave_gallery")
    folder.mkdir(parents=True, exist_ok=True)
    rows = []
    for state in (2, 4, 6):
        seen = shoot(
            state,
            {
                "usv": agent("wamv", (0, 0, 0), 0, {"position_m": [0.3, 0, 1.9], "orientation_deg": [0, 8, 0]}),
                "boat": agent("wamv", (0.5, 11, 0), 0, {"position_m": [0, -1, 2.2], "orientation_deg": [0, 6, -90],
                                                      "horizontal_fov_deg": 70}),
            },
            6.0,
        )  # fmt: skip
        rows.append(np.concatenate([seen["boat"], seen["usv"]], axis=1))
    save(folder / "wave_usv.jpg", np.concatenate(rows))
    up = {"position_m": [0.8, 0, 0.1], "orientation_deg": [0, -35, 0], "horizontal_fov_deg": 100}
    under = [shoot(state, {"auv": agent("remus100", (0, 0, 2), 0, up)}, 4.0)["auv"] for state in (2, 4)]
    save(folder / "wave_auv.jpg", np.concatenate(under, axis=1))


def save(path: Path, picture: np.ndarray) -> None:
    """As JPEG."""
    Image.fromarray(picture).save(path, quality=82)
    print(path, f"{path.stat().st_size // 1024} kB")


if __name__ == "__main__":
    main()
