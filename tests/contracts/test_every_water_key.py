"""Nothing of the water is accepted that is then ignored, and every sign is heard: currents, waves, tides, water masses,
tracers, wind, sky.

Each kind of component is built alone with all its keys away from 0 and from their defaults, and asked at places and
times of both signs, unequal on all axes; then one number after another moves a little, and changes its sign where it
may have one.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any, get_args

import numpy as np
import pytest
from pydantic import ValidationError

from known import check, flat
from pelagos import jit
from pelagos.errors import PelagosError
from pelagos.math.geodesy import GeoOrigin
from pelagos.ocean.config import CurrentConfig, OceanConfig, build_ocean
from pelagos.ocean.tracer import FieldConfig
from pelagos.ocean.wave_system import WavesConfig

DRAWN = {"spreading": 6.0, "components_count": 30, "towards_deg": -65.0}
SEA = DRAWN | {"significant_height_m": 1.3, "peak_period_s": 6.1}
CURRENTS: dict[str, dict[str, Any]] = {
    "uniform": {"speed_mps": 0.7, "towards_deg": -65.0, "up_mps": 0.11},
    "profile": {"depth_m": [0.7, 9.0, 31.0], "speed_mps": [0.3, 0.7, 0.2], "towards_deg": [-65.0, 20.0, 130.0]},
    "shear": {"speed_mps": 0.7, "per_m": -0.013, "towards_deg": -65.0},
    "tidal": {"period_h": 5.0, "speed_mps": 0.7, "across_mps": -0.2, "towards_deg": -65.0, "phase_deg": 40.0},
    "vortex": {
        "center_m": [13.0, -8.0], "radius_m": 17.0, "speed_mps": -0.7, "drift_mps": 0.03, "drift_towards_deg": 130.0,
    },
    "jet": {"through_m": [13.0, -8.0], "towards_deg": -65.0, "speed_mps": 0.7, "width_m": 23.0, "depth_m": 12.0},
    "gyre": {"center_m": [13.0, -8.0], "radius_m": 17.0, "period_s": -900.0},
    "turbulence": {"rms_mps": 0.3, "largest_m": 40.0, "smallest_m": 3.0, "modes": 12},
}  # fmt: skip
WAVES: dict[str, dict[str, Any]] = {
    "regular": {"height_m": 0.9, "period_s": 5.3, "towards_deg": -65.0, "phase_deg": 40.0},
    "jonswap": SEA | {"gamma": 2.1},
    "tma": SEA | {"gamma": 2.1},
    "pierson_moskowitz": DRAWN | {"wind_mps": 9.0},
    "ochi_hubble": SEA | {"sharpness": 2.2},
    "torsethaugen": SEA,
    "sea_state": DRAWN | {"state": 4},
    "table": DRAWN | {"frequency_hz": [0.11, 0.16, 0.24], "density_m2phz": [0.4, 1.3, 0.2]},
}
SOURCE = {"source_m": [13.0, -8.0, -7.0], "rate": 3.0, "spread_m2ps": 0.4, "spread_up_m2ps": 0.07, "initial_m": 1.5}
FIELDS: dict[str, dict[str, Any]] = {
    "uniform": {"value": 1.7},
    "profile": {"depth_m": [0.7, 9.0, 31.0], "value": [1.7, 0.4, 2.6]},
    "gradient": {"per_m": 0.013, "towards_deg": -65.0, "per_m_down": -0.02},
    "oscillation": {"amplitude": 0.8, "period_h": 5.0, "phase_deg": 40.0},
    "patch": {"center_m": [13.0, -8.0, -7.0], "radius_m": 17.0, "height_m": 6.0, "value": 1.7},
    "front": {"through_m": [13.0, -8.0], "towards_deg": -65.0, "step": 1.7, "width_m": 23.0},
    "plume": SOURCE | {"speed_mps": 0.2, "towards_deg": -65.0},
    "drifting_plume": SOURCE | {"duration_s": 7300.0, "puffs": 15},
}
FROM_FILES = {"gridded", "python"}
PARTS = [
    *(("currents", kind) for kind in CURRENTS), *(("waves", kind) for kind in WAVES),
    *(pytest.param("dye", kind, marks=pytest.mark.slow if kind == "drifting_plume" else ()) for kind in FIELDS),
    ("tide", "tide"), ("wind", "wind"), ("sun", "sun"), ("weather", "weather"),
]  # fmt: skip
SINGLE: dict[str, dict[str, Any]] = {
    "tide": {"period_h": 5.0, "amplitude_m": 0.8, "phase_deg": 40.0},
    "wind": {"speed_mps": 7.0, "from_deg": -65.0, "gusts": 0.7, "gust_components": 9},
    "sun": {"elevation_deg": 31.0, "azimuth_deg": -65.0},
    "weather": {"cloud": 0.4, "visibility_m": 900.0, "rain_mm_per_h": 3.0},
}
DEAF: dict[str, str] = {}
"""Keys that nothing hears, and why."""


def whole(part: str, kind: str, config: dict[str, Any]) -> dict[str, Any]:
    """An ocean with one component."""
    if part in ("currents", "waves"):
        deep = {"waves_depth_m": 25.0} if kind == "tma" else {}
        return {part: [{"type": kind, **config}], **deep}
    if part == "dye":
        carried = {"currents": [{"type": "uniform", "speed_mps": 0.2, "towards_deg": -65.0}]}
        return {"tracers": {"dye": [{"type": kind, **config}]}, **(carried if kind == "drifting_plume" else {})}
    return {part: [config] if part == "tide" else config}


def asked(part: str, kind: str, config: dict[str, Any]) -> list[Any]:
    """What an ocean with one component says at seven places and times."""
    ocean = build_ocean(
        OceanConfig.model_validate(whole(part, kind, config)), SimpleNamespace(origin=GeoOrigin(45.0, 13.0)), seed=3
    )
    rng = np.random.default_rng(5)
    x, y, z = rng.uniform(-1, 1, (3, 7)) * [[31.0], [19.0], [11.0]] - [[0.0], [0.0], [12.0]]
    place, t = jit.Array3f64(*(jit.Float64(v) for v in (x, y, z))), jit.Float64(rng.uniform(1.0, 7000.0, 7))
    if part == "dye":
        return [ocean.tracer("dye", place, t)]
    if part == "currents":
        return [ocean.current(place, t)]
    if part == "waves":
        motion = ocean.wave_motion(place, t)
        return [motion.velocity, motion.elevation]
    if part == "wind":
        return [ocean.wind(jit.Array3f64(place.x, place.y, -place.z), t)]
    if part == "tide":
        return [ocean.elevation(place.x, place.y, t)]
    return [ocean.sun_elevation, ocean.sun_azimuth, np.array([ocean.cloud, ocean.visibility, ocean.rain])]


def digest(part: str, kind: str, config: dict[str, Any]) -> bytes | None:
    """Of what an ocean with one component says; None if the configuration is refused."""
    try:
        found = asked(part, kind, config)
    except (PelagosError, ValidationError):
        return None
    told = hashlib.blake2b(digest_size=8)
    for values in found:
        told.update(np.ascontiguousarray(np.array(values)).tobytes())
    return told.digest()


def moved(config: dict[str, Any]) -> Iterator[tuple[str, str, Any]]:
    """Each number with others in its place: `(path, "value" or "sign", all of the key)`."""
    for key, value in config.items():
        rows = value if isinstance(value, list) else [value]
        for k, v in enumerate(rows):
            at = f"{key}.{k}" if isinstance(value, list) else key
            for what, other in (("value", v + 1 if isinstance(v, int) else 1.07 * v), ("sign", -v)):
                yield at, what, [*rows[:k], other, *rows[k + 1 :]] if isinstance(value, list) else other


def test_every_kind_of_component_is_tried() -> None:
    for union, tried in ((CurrentConfig, CURRENTS), (WavesConfig, WAVES), (FieldConfig, FIELDS)):
        kinds = {part.model_fields["type"].default for part in get_args(get_args(union)[0])}
        assert kinds - FROM_FILES == set(tried)


@pytest.mark.parametrize(("part", "kind"), PARTS)
def test_every_number_and_every_sign_of_the_water_is_heard_as_known(part: str, kind: str) -> None:
    config = (SINGLE if part in SINGLE else {"currents": CURRENTS, "waves": WAVES, "dye": FIELDS}[part])[kind]
    changed = {at: {**config, at.split(".")[0]: value} for at, what, value in moved(config) if what == "value"}
    numbers = {at: flat(np.array(v) for v in asked(part, kind, keys)) for at, keys in ({"": config} | changed).items()}
    check("keys_of_water", f"{part} {kind}", numbers)
    plain = digest(part, kind, config)
    assert plain is not None
    found = {
        f"{part}.{kind}.{at} ({what})": digest(part, kind, {**config, at.split(".")[0]: value})
        for at, what, value in moved(config)
    }
    assert all(found[name] is not None for name in found if name.endswith("(value)"))
    deaf = sorted(name for name, value in found.items() if value == plain)
    assert deaf == sorted(name for name in DEAF if name.startswith(f"{part}.{kind}."))
