"""What rays meet and how deep it is in every kind of world; what every kind of current, wave and water gives."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from test_every_water_key import CURRENTS, FIELDS, SINGLE, WAVES, asked
from test_every_world import NAMES, NEEDS

import pelagos as pl
from known import DOUBLE, check
from pelagos.world.build import build_world, world_config
from pelagos.world.export import save
from pelagos.world.generate.objects import KINDS as PLACED

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


@pytest.mark.parametrize("kind", sorted(PLACED))
def test_kinds_of_things(kind: str) -> None:
    """Vertices of one thing of each kind, and its labels."""
    size = {"size_m": [60, 60], "depth_m": 14.0, "seed": 3}
    world = build_world(world_config({"type": "generated", **size, "objects": [{"kind": kind, "at_m": [[3.0, -4.0]]}]}))
    things = [g for g in world.geometries if g.name != "seabed"]
    vertices = np.concatenate([g.vertices for g in things])
    labels = [g.label for g in things]
    check("kinds", kind, {"vertices": vertices, "faces": [sum(len(g.faces) for g in things)], "labels": labels})


def test_a_channel_between_two_vehicles_that_pass() -> None:
    deep = {"type": "profile", "depth_m": [0.0, 12.0, 40.0], "value": [18.0, 11.0, 7.0]}
    auv = {"vehicle": "remus100", "control": "depth_heading"}
    agents = {
        "a": {**auv, "start": {"position_m": [0.0, 0.0], "depth_m": 7.0, "heading_deg": 20.0, "speed_mps": 1.5}},
        "b": {**auv, "start": {"position_m": [310.0, -90.0], "depth_m": 23.0, "heading_deg": 200.0, "speed_mps": 1.0}},
    }
    things = [{"shape": "box", "at_m": [150.0, -44.0, -6.0], "size_m": [3.0, 9.0, 6.0]}]
    sim = pl.Simulation.load(
        {"tick_rate_hz": 50, "world": {"type": "flat", "depth_m": 34.0, "size_m": [2000, 2000], "things": things},
         "ocean": {"temperature_c": [deep], "wind": {"speed_mps": 6.0, "from_deg": 30.0}}, "agents": agents}
    )  # fmt: skip
    sim.step(ticks=20)
    link = pl.channel(sim, "a", "b", frequency_hz=18e3)
    a = link.arrivals()
    field = link.field(columns=24, rows=12, beams=200)
    sent = np.exp(2j * np.pi * np.array([0.1, 0.13, 0.2, 0.05, -0.1, 0.3, 0.02, -0.4]).cumsum())
    start, got = link.transmit(np.repeat(sent, 6), 6e3, source_level_db=150.0)
    found = {
        "delay": a.delay, "amplitude": a.amplitude * 1e3, "departure": a.departure, "arrival": a.arrival,
        "doppler": (a.doppler - 1) * 1e3, "length": a.length, "bounces": [a.surface, a.bottom, a.caustics],
        "blocked": a.blocked, "loss": [link.transmission_loss(), link.transmission_loss(coherent=True)],
        "noise": [link.noise_level_db(), link.noise_level_db(300.0)], "field": field.loss_db, "got": got,
        "start": [start],
    }  # fmt: skip
    check("channel", "two vehicles", found)


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
