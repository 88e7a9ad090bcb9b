"""What rays meet and how deep it is in every kind of world; what every kind of current, wave and water gives."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from test_every_water_key import CURRENTS, FIELDS, SINGLE, WAVES, asked
from test_every_world import NAMES, NEEDS

from known import DOUBLE, check
from pelagos.world.build import build_world, world_config
from pelagos.world.export import save

X, Y = np.random.default_rng(8).uniform(-70.0, 90.0, (2, 40))


@pytest.mark.parametrize("name", NAMES)
def test_worlds(name: str, tmp_path: Any) -> None:
    keys = NEEDS.get(name, {}) if name != "saved" else {}
    if name == "saved":
        small = build_world(world_config({"type": "flat", "size_m": [60, 60]}))
        keys = {"path": str(save(small, tmp_path / "world.npz"))}
    world = build_world(world_config({"type": name, **keys}))
    low, high = world.bounds
    middle, half = (low + high) / 2, np.minimum((high - low) / 2, 80.0)
    turns = np.random.default_rng(4).uniform(-1.0, 1.0, (300, 6))
    start = middle + half * turns[:, :3] * [0.9, 0.9, 0.5]
    toward = turns[:, 3:] / np.linalg.norm(turns[:, 3:], axis=1, keepdims=True)
    hits = world.cast(start, toward, 60.0)
    near = world.near(start, 3.0)
    found = {
        "bounds": world.bounds, "triangles": [world.triangles, len(world.geometries)],
        "height": world.height(middle[0] + X, middle[1] + Y),
        "range": np.where(hits.valid, hits.t, 60.0), "valid": hits.valid, "near": near,
        "normal": np.where(hits.valid[:, None], hits.normal, 0.0),
        "label": np.where(hits.valid, hits.label, 0), "material": np.where(hits.valid, hits.material, 0),
        "origin": [world.origin.latitude, world.origin.longitude],
    }  # fmt: skip
    check("worlds", name, found)


KINDS = [*(("currents", k) for k in CURRENTS), *(("waves", k) for k in WAVES), *(("dye", k) for k in FIELDS)]


@pytest.mark.parametrize(("part", "kind"), [*KINDS, *((part, part) for part in SINGLE)])
def test_water(part: str, kind: str) -> None:
    config = (SINGLE if part in SINGLE else {"currents": CURRENTS, "waves": WAVES, "dye": FIELDS}[part])[kind]
    if kind == "drifting_plume":
        config = {**config, "duration_s": 400.0}
    check(
        "water",
        f"{part} {kind}",
        {str(k): np.array(values) for k, values in enumerate(asked(part, kind, config))},
        DOUBLE,
    )
