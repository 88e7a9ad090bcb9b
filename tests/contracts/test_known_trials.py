"""Numbers and pictures of manoeuvres, and of parameters that are found in a record of a motion or of noise."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

import made_up
from known import DOUBLE, SINGLE, check
from pelagos.errors import PelagosWarning
from pelagos.identification import fit, load_plan, read_record
from pelagos.identification.clock import clock_of
from pelagos.identification.fit import open_loop
from pelagos.identification.noise import fit_beams, fit_noise, keys_of
from pelagos.identification.output import draw as draw_fit
from pelagos.identification.output import vehicle_yaml, write_fit
from pelagos.identification.plan import ColumnConfig
from pelagos.identification.recording import read_recording
from pelagos.manoeuvres import picture, run_manoeuvre
from pelagos.manoeuvres.measures import decay_measures, stop_measures, turning_measures, zigzag_measures
from pelagos.manoeuvres.orders import Orders
from pelagos.report import theme
from shown import figure, page, parts

TRIALS: dict[str, tuple[str, str, Orders]] = {
    "turning": ("mariner", "turning", Orders(rudder_deg=-30.0, seconds=240)),
    "zigzag": ("mariner", "zigzag", Orders(rudder_deg=-20, angle_deg=4)),
    "spiral": ("mariner", "spiral", Orders(rudder_deg=15, seconds=2)),
    "stop": ("otter", "stop", Orders(seconds=4)),
    "decay": ("otter", "decay", Orders(angle_deg=8, seconds=8)),
    "bollard": ("bluerov2_heavy", "bollard", Orders()),
    "bollard of a hull": ("otter", "bollard", Orders()),
}


@pytest.fixture
def figures(monkeypatch: pytest.MonkeyPatch) -> list[Figure]:
    """Figures that would become pictures."""
    found: list[Figure] = []

    def keep(drawn: Figure, **how: Any) -> bytes:
        found.append(drawn)
        return b"picture"

    monkeypatch.setattr(theme, "as_png", keep)
    return found


@pytest.mark.parametrize("case", TRIALS)
def test_manoeuvres(case: str, figures: list[Figure]) -> None:
    vehicle, name, orders = TRIALS[case]
    trial = run_manoeuvre({"type": vehicle}, name, orders)
    picture.draw(trial)
    told = [(m.name, m.unit, m.limit, m.kept) for m in trial.measures]
    t = trial.track
    found = {
        "values": [m.value for m in trial.measures], "time": t.time, "position": t.position, "attitude": t.attitude,
        "velocity": t.velocity, "switched": trial.switched_s,
    }  # fmt: skip
    found |= parts("told", [told, trial.ordered, trial.vehicle, trial.length_m, trial.beam_m])
    check("trials", case, found | figure(figures[0]), DOUBLE)


def test_numbers_of_tracks() -> None:
    t = np.arange(0.0, 60.0, 0.25)
    turned = np.radians(11.0 * np.maximum(t - 4.0, 0.0) ** 1.05)
    along, across = 2.0 * t + 3 * np.sin(turned), -1.7 * np.cumsum(np.sin(turned)) * 0.25
    heading = np.degrees(-turned) + 25.0
    roll = 0.2 * np.exp(-0.06 * t) * np.cos(1.3 * t + 0.2) + 0.003
    swing = 14.0 * np.sin(t / 6.0) + 3.0 * np.sin(t / 2.5)
    found = {
        "turning": turning_measures(t, along, across, heading, ordered_s=4.0, length_m=3.1),
        "zigzag": zigzag_measures(
            t, swing, np.array([4.0, 13.0, 30.0, 41.0, 55.0]), rudder_deg=10.0, angle_deg=10.0, length_m=90.0,
            speed_m_s=6.0, run_lengths=1.7,
        ),
        "stop": stop_measures(along[:40], across[:40], heading_deg=33.0, length_m=3.1),
        "decay": decay_measures(t, roll),
    }  # fmt: skip
    told = {name: [(m.name, m.value, m.unit, m.limit) for m in measures] for name, measures in found.items()}
    check("trials", "tracks", parts("measures", told), DOUBLE)


THRUSTER = {"type": "force_thruster", "low_n": -30, "high_n": 25, "time_constant_s": 0.4, "direction": [1, 0, 0]}
BOAT: dict[str, Any] = {
    "type": "custom", "length_m": 1.2, "beam_m": 0.5, "height_m": 0.5, "density_kg_m3": 1000,
    "mass": {"type": "explicit", "mass_kg": 20, "inertia_kg_m2": [1, 2, 2.2], "center_of_gravity_m": [0.04, 0, 0.05],
             "center_of_buoyancy_m": [0.04, 0, -0.15]},
    "added_mass": {"type": "diagonal", "diagonal": [4, 15, 15, 0.3, 1.5, 1.2]},
    "terms": {"weight": {"type": "submerged"}, "damping": {"type": "linear_damping", "diagonal": [6, 12, 20, 2, 4, 3]}},
    "actuators": {"port": {**THRUSTER, "position_m": [-0.4, -0.2, 0]}, "starboard": {**THRUSTER, "position_m": [-0.4,
    0.3, 0]}},
    "modes": {"actuators": {"type": "actuators"}}, "default_mode": "actuators",
}  # fmt: skip
PLAN: dict[str, Any] = {
    "columns": {"north": "x", "east": "y", "heading": {"column": "psi", "unit": "deg"}},
    "commands": {"port": "left", "starboard": {"column": "right", "scale": 1.1}}, "segment_s": 3, "bootstrap": 40,
    "iterations": 3, "start": {"depth": 4}, "continuity": {"heading": 0.02, "north": 0.05}, "train": 0.7,
    "parameters": {
        "X_u": {"path": "terms.damping.diagonal.0"}, "N_r": {"path": "terms.damping.diagonal.5"},
        "current.east": {"spread": 0.3}, "lag": {"path": ["actuators.port.time_constant_s",
        "actuators.starboard.time_constant_s"], "low": 0.05, "high": 3},
    },
}  # fmt: skip


def sailed(rows: int = 161) -> dict[str, Any]:
    """A track that a boat might leave: nobody simulated it, so that differences stay."""
    t = 0.1 * np.arange(rows)
    left, right = 12.0 * np.sign(np.sin(t)) + 3.0, 14.0 * np.sign(np.cos(0.7 * t)) + 2.0
    heading = 0.5 * np.sin(0.45 * t) + 0.05 * t
    speed = 0.5 + 0.2 * np.sin(0.6 * t)
    x, y = np.cumsum(0.1 * speed * np.cos(heading)), np.cumsum(0.1 * (speed * np.sin(heading) + 0.07))
    noise = np.random.default_rng(6).normal(0.0, 0.004, (3, rows))
    return {
        "t": t,
        "x": x + noise[0],
        "y": y + noise[1],
        "psi": np.degrees(heading + noise[2]),
        "left": left,
        "right": right,
    }


def test_a_fit(figures: list[Figure], tmp_path: Path, recwarn: pytest.WarningsRecorder) -> None:
    plan = load_plan(PLAN)
    record = read_record(sailed(), plan)
    with pytest.warns(PelagosWarning):
        made = fit(BOAT, record, plan)
    found: dict[str, Any] = {
        "values": [[e.value, e.low, e.high, *e.fisher, *(e.resampled or ()), e.told, e.identified]
        for e in made.estimates],
        "fisher": made.certainty.fisher, "memory": made.certainty.memory, "at": made.found.at,
        "loss": made.found.normal.loss, "gradient": made.found.normal.gradient, "matrix": made.found.normal.matrix,
        "simulated": made.simulated[0], "doubts": "\n".join(made.doubts),
    }  # fmt: skip
    for name, score in (("train", made.train), ("test", made.test), ("before", made.before)):
        assert score is not None
        found |= parts(name, [score.r2, score.rms, score.shots, score.seconds])
    draw_fit(made)
    found |= {f"picture {k}": v for k, v in figure(figures[0]).items()}
    text = vehicle_yaml(made, data="tank.csv")
    found |= parts("vehicle", re.sub(r"(?m)^#.*pelagos \S+.*$", "", text))
    files = write_fit(made, tmp_path / "fit", data="tank.csv", title="a tank")
    found |= page(re.sub(r"pelagos [\d.]+|<b>\d+ <small>s</small></b><span>on the clock", "", files[3].read_text()))
    said = json.loads(files[1].read_text())
    found |= parts("fit", {k: said[k] for k in sorted(said) if k not in ("seconds", "version", "pelagos")})
    score, seen, _ = open_loop(BOAT, record, plan, {"current.east": 0.05, "offset.heading": 0.02})
    found |= {"open loop": seen} | parts("score", [score.r2, score.rms])
    check("trials", "a fit", found, SINGLE)


def test_records() -> None:
    found: dict[str, Any] = {}
    data = {k: np.delete(v, slice(70, 100)) for k, v in sailed().items()}
    for name, plan in (("gaps", {"gaps": "split"}), ("slow", {"gaps": "split", "step_s": 0.25, "smooth_s": 0.9})):
        record = read_record(data, load_plan({**PLAN, **plan}))
        found[f"{name} runs"] = record.runs
        for part in ("north", "east", "heading", "u", "v", "r"):
            values = record.values(part)
            if values is not None:
                found[f"{name} {part}"] = values
        found |= {f"{name} {a}": c for a, c in record.commands.items()}
    clocks = [
        clock_of(x, ColumnConfig(column="t"), "it")
        for x in (1.7e9 + 0.02 * np.arange(300), 3.0 + np.round(np.arange(200) / 30.0, 3))
    ]
    found["clocks"] = [[c.start_s * 1e-9, c.step_s, c.grain_s, c.t[-1]] for c in clocks]
    found["said"] = "\n".join(c.say(1.25) for c in clocks)
    check("trials", "records", found, DOUBLE)


def test_a_recording_as_a_record(tmp_path: Path) -> None:
    path = made_up.record(tmp_path / "it.mcap", ("depth", "dvl", "imu"))
    topics = {
        "z": "/auv0/depth/pose.pose.pose.position.z", "u": "/auv0/dvl/twist.twist.twist.linear.x",
        "r": "/auv0/imu/data_raw.angular_velocity.z", "n": "/auv0/truth.pose.pose.position.y",
    }  # fmt: skip
    found, start_s = read_recording(path, list(topics.values()), {topics["u"]})  # lines over a hole, and a held value
    said = {name: found[topic] for name, topic in topics.items()}
    del topics["u"]
    plan = load_plan({
        "columns": {"depth": {"column": topics["z"], "scale": -1}, "r": topics["r"], "north": topics["n"]},
        "commands": {}, "parameters": {},
    })  # fmt: skip
    record = read_record(path, plan)
    said |= {f"of a record: {n}": v for n in ("depth", "u", "r", "north") if (v := record.values(n)) is not None}
    check("trials", "a recording as a record", said | {"runs": record.runs, "step": [record.step_s, start_s]}, DOUBLE)


def test_noise_of_records() -> None:
    random = np.random.default_rng(4)
    found: dict[str, Any] = {}
    made = {}
    for name, values in (
        ("walk", 5 + 0.02 * random.normal(size=3000) + 0.003 * np.cumsum(random.normal(size=3000))),
        ("steps", np.round(random.normal(0, 0.3, 2500) / 0.05) * 0.05),
    ):
        made[name] = n = fit_noise(values, 20.0)
        found[name] = [
            n.white.value,
            n.white.visible,
            n.bias_instability.value,
            n.random_walk.value,
            n.resolution,
            n.mean,
            n.deviation,
        ]
        found[f"{name} allan"] = n.allan
    found["keys"] = list(keys_of(made, "gyroscope_").values())
    v = np.stack(
        [0.8 + 0.3 * np.sin(np.arange(900) / 50.0), 0.2 * np.cos(np.arange(900) / 31.0), 0.05 + 0 * np.arange(900)]
    )
    turns = np.radians([45.0, 135.0, 225.0, 315.0])
    beams = [np.cos(a) * v[0] + np.sin(a) * v[1] - 0.8 * v[2] for a in turns]
    beams = [b + 0.01 * random.normal(size=900) + 0.02 * b * random.normal(size=900) for b in beams]
    beams[2][40:70] = np.nan
    b = fit_beams(beams)
    found |= {"beams": [b.noise_mps, b.noise_relative], "lost": [*b.lost, b.pings * 1e-3]}
    check("trials", "noise", found, DOUBLE)
