"""One reading of every instrument, all of them on one vehicle in the harbour: its walk, its arrays and a picture."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import numpy as np

from pelagos.cli.walk import last_motion, rooms, walked
from pelagos.config import registry

AHEAD = (0, 20, 0)
BEACONS: Final = {
    "quay": {"position_m": [-25, 55, -5]},
    "pier": {"position_m": [-10, 30, -6]},
    "reef": {"position_m": [-35, 20, -5]},
}  # fmt: skip
KEYS: Final[dict[str, dict[str, Any]]] = {
    "tracer": {"tracer": "oxygen"},
    "lbl": {"transponders": BEACONS},
    "range_bearing": {"targets": BEACONS},
    "imaging_sonar": {"orientation_deg": [0, 12, 0], "beams": 256, "bins": 512, "range_max_m": 30},
    "profiling_sonar": {"orientation_deg": [90, 0, 0], "range_max_m": 30},
    "mechanical_scanning_sonar": {"range_max_m": 30},
    "synthetic_aperture_sonar": {"range_max_m": 40},
    "multibeam": {"beams": 128},
}
SIZE: Final = {"width_px": 320, "height_px": 240, "orientation_deg": list(AHEAD)}


@dataclass
class Read:
    """What one reading was.

    Attributes:
        rooms: files passed, with the functions that ran in each.
        steps: (name, shape, least, mean, greatest, unit) of the arrays that `explain` shows.
        arrays: (name, shape, type) of the reading itself.
        picture: file name of its picture; empty without one.
    """

    rooms: dict[str, list[str]] = field(default_factory=dict)
    steps: list[tuple[str, Any, str, str, str, str]] = field(default_factory=list)
    arrays: list[tuple[str, Any, str]] = field(default_factory=list)
    picture: str = ""


def scenario() -> dict[str, Any]:
    """Every kind of sensor on one vehicle between the piles of the harbour."""
    sensors: dict[str, Any] = {}
    for name, entry in registry.entries("sensor", plugins=False).items():
        own = dict(KEYS.get(name, {}))
        if "width_px" in entry.config.model_fields:
            own = SIZE | own
        sensors[name] = {"type": name, "rate_hz": 2, "position_m": [0.9, 0, 0], **own}
    start = {"position_m": [-40, 40], "depth_m": 4.0, "heading_deg": 60, "speed_mps": 1.0}
    auv = {
        "vehicle": "remus100",
        "start": start,
        "sensors": sensors,
        "control": "depth_heading",
        "command": [4.0, 1.05, 600.0],
    }
    ocean = {
        "water_type": "II",
        "sun": {"elevation_deg": 55},
        "tracers": {"oxygen": 240.0, "chlorophyll": 1.2, "turbidity": 1.0},
    }
    return {"world": {"type": "harbour"}, "ocean": ocean, "agents": {"auv0": auv}}


def all_read(folder: Path) -> dict[str, Read]:
    """Read every instrument once, by name, and draw what it gave into `folder`."""
    import pelagos as pl

    folder.mkdir(parents=True, exist_ok=True)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        sim = pl.Simulation.load(scenario())
        observed = dict(sim.run(1.0).observations["auv0"])
        motion = last_motion(sim, "auv0")
        found = {}
        for name, model in sim.model.agents["auv0"].sensors.items():
            built = model.sensor
            work = built.explain if hasattr(built, "explain") else built.sense
            passed, result = walked(lambda work=work: work(motion))
            steps = result if isinstance(result, list) else [("truth", result.truth, ""), ("data", result.data, "")]
            read = Read(rooms(passed), [(n, np.shape(a), *_range(np.asarray(a)), unit) for n, a, unit in steps])
            if name in observed:
                reading = observed[name]
                arrays = {"data": reading.data, "truth": reading.truth, **reading.extras}
                read.arrays = [(n, a.shape, str(a.dtype)) for n, a in arrays.items()]
                read.picture = drawn(name, reading, folder)
            found[name] = read
    return found


def _range(array: Any) -> tuple[str, str, str]:
    values = np.abs(array) if np.iscomplexobj(array) else array.astype(float)
    finite = values[np.isfinite(values)]
    if not finite.size:
        return "", "", ""
    return f"{finite.min():.5g}", f"{finite.mean():.5g}", f"{finite.max():.5g}"


def drawn(name: str, reading: Any, folder: Path) -> str:
    """A picture of a reading that is one: images, fans and profiles; else nothing."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    data = np.asarray(reading.data[0])
    figure, axes = plt.subplots(figsize=(5, 3.4), dpi=90, layout="constrained")
    if data.ndim == 3 and data.shape[-1] == 3 and data.dtype.kind in "ui":
        axes.imshow(data)
        axes.axis("off")
    elif "azimuth" in reading.extras and "range" in reading.extras and data.ndim == 2:
        angle, distance = reading.extras["azimuth"], reading.extras["range"]
        x = distance * np.sin(angle)[:, None] * -1
        y = distance * np.cos(angle)[:, None]
        axes.pcolormesh(x, y, data, cmap="copper", shading="nearest", rasterized=True)
        axes.set(xlabel="to starboard [m]", ylabel="ahead [m]", aspect="equal")
    elif data.ndim == 3 and data.shape[-1] == 3:
        axes.imshow(np.clip(0.5 + 0.5 * np.nan_to_num(data), 0, 1))
        axes.axis("off")
    elif data.ndim == 2 and min(data.shape) > 8:
        shown = axes.imshow(
            np.where(np.isfinite(data), data, np.nan), cmap="viridis", aspect="auto" if name != "depth_camera" else None
        )
        figure.colorbar(shown, ax=axes)
        axes.axis("off")
    elif data.ndim >= 1 and data.shape[0] >= 16 and data.dtype.kind == "f":
        axes.plot(data.reshape(data.shape[0], -1)[:, :3], lw=0.8)
        axes.set(xlabel="element", ylabel="data")
    else:
        plt.close(figure)
        return ""
    file = f"{name}.png"
    figure.savefig(folder / file)
    plt.close(figure)
    return file
