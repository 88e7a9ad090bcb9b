"""An AUV with T200 thrusters in a pool: yaw and heave by pulse widths."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import NDArray
from page import Chapter, Row, keep, relative, table

import pelagos as pl
from pelagos.report import theme

FOLDER: Final = "09_auv_bolt_pool"
TITLE: Final = "An AUV in a pool"
SOURCE: Final = (
    "AUV Bolt, eight T200 thrusters, pool tests of ASMarine, Alexandria (SamMans/AUV-Simulator, MIT). Kept: "
    "tables/bolt.csv, all records."
)
Array = NDArray[np.float64]

RECORDS: Final = ("yaw_test", "Yaw_test_3", "Yaw_test_5", "depth_test", "Depth_test_4")
THRUSTERS: Final = (1, 2, 5, 6, 7, 8)  # those that were used
STEP_S: Final = 0.05


def chapter(data: Path | None) -> Chapter:
    """Rows and picture."""
    if data is not None and (data / FOLDER).is_dir():
        _keep(data / FOLDER)
    seen = {name: _record(name) for name in RECORDS}
    ran = {name: _simulated(seen[name]) for name in RECORDS}

    def pair(name: str, column: str, what: Any) -> tuple[float, float]:
        t = seen[name]["t"]
        return what(t, seen[name][column]), what(t, np.interp(t, ran[name]["t"], ran[name][column]))

    def end_rate(t: Array, x: Array) -> float:
        """Mean slope over the last third."""
        return float(np.polyfit(t[2 * len(t) // 3 :], x[2 * len(t) // 3 :], 1)[0])

    def rise(t: Array, x: Array) -> float:
        """Time at which a steady motion, drawn back, would have begun, from the first command."""
        slope, zero = np.polyfit(t[2 * len(t) // 3 :], x[2 * len(t) // 3 :], 1)
        return float((x[0] - zero) / slope)

    def swing(t: Array, x: Array) -> float:
        """Amplitude of the swing of 5 s about a line, over the second half."""
        late = t >= t[-1] / 2
        phase = 2 * np.pi * t[late] / 5.0
        basis = np.stack([np.ones_like(phase), phase, np.cos(phase), np.sin(phase)], axis=-1)
        return float(np.hypot(*np.linalg.lstsq(basis, x[late], rcond=None)[0][2:]))

    turned = "yaw rate over the last third"
    rows: list[Row] = [
        relative("pulses to and fro, amplitude of the swing", "deg", *_degrees(pair("yaw_test", "yaw", swing)), 15.0),
        relative(f"one-way yaw pulses, {turned}", "deg/s", *_degrees(pair("Yaw_test_3", "yaw", end_rate)), 15.0),
        relative("one-way yaw pulses, delay of the steady turn", "s", *pair("Yaw_test_3", "yaw", rise), 15.0),
        relative(f"step of yaw pulses, {turned}", "deg/s", *_degrees(pair("Yaw_test_5", "yaw", end_rate)), 15.0),
        relative("step of yaw pulses, delay of the steady turn", "s", *pair("Yaw_test_5", "yaw", rise), 15.0),
        relative("heave pulses, speed of sinking over the last third", "m/s", *pair("Depth_test_4", "depth", end_rate),
                 15.0),
        relative("heave pulses, delay of the steady descent", "s", *pair("Depth_test_4", "depth", rise), 15.0),
    ]  # fmt: skip
    return Chapter(TITLE, _ABOUT, SOURCE, rows, _MISSED, _picture(seen, ran), "bolt")


def _degrees(values: tuple[float, float]) -> tuple[float, float]:
    return float(np.degrees(values[0])), float(np.degrees(values[1]))


def _record(name: str) -> dict[str, Array]:
    t = table("bolt.csv")
    chosen = t["record"] == RECORDS.index(name)
    return {key: values[chosen] for key, values in t.items() if key != "record"}


def vehicle() -> dict[str, Any]:
    """The vehicle by its maker's numbers (`bolt_physical.mat`); thrusters that the records do not use are left out."""

    def thruster(x: float, y: float, axis: list[float]) -> dict[str, Any]:
        return {
            "type": "t200", "position_m": [x, y, 0.0], "direction": axis, "time_constant_s": 0.0,
            "dynamics": "third_order",
        }  # fmt: skip

    down, aslant = [0.0, 0.0, 1.0], 0.375 / 2**0.5  # R_Hor: radius of the horizontal thrusters, at 45 deg
    return {
        "type": "custom", "title": "AUV Bolt", "density_kg_m3": 997.0, "gravity_m_s2": 9.81,
        "length_m": 0.6, "beam_m": 0.6, "height_m": 0.3,
        "mass": {
            "type": "explicit", "mass_kg": 25.305, "volume_m3": 0.0258, "inertia_kg_m2": [5.4746, 9.9998, 5.1456],
            "center_of_buoyancy_m": [-0.004, 0.003, -0.1002],
        },
        "added_mass": {"type": "diagonal", "diagonal": [55.6, 41.925, 171.934, 0.0, 0.0, 0.0]},
        "terms": {
            "drag": {"type": "quadratic_damping", "diagonal": [222.416, 167.4, 271.222, 9.0, 10.0, 3.1672]},
            "restoring": {"type": "submerged"},
        },
        "actuators": {
            "T1": thruster(aslant, aslant, [1.0, -1.0, 0.0]), "T2": thruster(aslant, -aslant, [1.0, 1.0, 0.0]),
            "T5": thruster(0.14, 0.235, down), "T6": thruster(0.14, -0.235, down),
            "T7": thruster(-0.14, 0.235, down), "T8": thruster(-0.14, -0.235, down),
        },
        "battery": {"open_circuit_v": 16.0, "resistance_ohm": 0.03},
        "modes": {"actuators": {"type": "actuators"}}, "default_mode": "actuators",
    }  # fmt: skip


def _throttle(seen: dict[str, Array], number: int) -> Array:
    return np.asarray((seen[f"T{number}"] - 1500.0) / 400.0)


def _simulated(seen: dict[str, Array]) -> dict[str, Array]:
    """Time [s], yaw [rad] and depth [m] from the record's first, by its pulses alone."""
    sim = pl.Simulation.load({
        "name": "pool", "tick_rate_hz": 1 / STEP_S, "duration_s": 600.0, "world": {"type": "flat", "depth_m": 60.0},
        "agents": {"auv": {"vehicle": vehicle(), "start": {"position_m": [0.0, 0.0, -5.0]}, "control": "actuators"}},
    })  # fmt: skip
    count = round(float(seen["t"][-1]) / STEP_S)
    yaw, depth = np.zeros(count + 1), np.zeros(count + 1)
    for i in range(count):
        at = int(np.searchsorted(seen["t"], (i + 0.5) * STEP_S)) - 1
        sim.step({"auv": np.array([_throttle(seen, n)[at] for n in THRUSTERS])})
        state = sim.state["auv"]
        yaw[i + 1], depth[i + 1] = -state.euler[0, 2], state.depth[0]  # of NED
    depth[0] = 5.0
    return {
        "t": np.arange(count + 1) * STEP_S,
        "yaw": np.unwrap(yaw) + seen["yaw"][0],
        "depth": depth - depth[0] + seen["depth"][0],
    }


def _keep(folder: Path) -> None:
    parts = []
    for number, name in enumerate(RECORDS):
        t = np.genfromtxt(folder / f"{name}.csv", delimiter=",", skip_header=1)
        pulses = t[:, [5 + i for i in THRUSTERS]]
        parts.append(np.column_stack([np.full(len(t), number), t[:, 14], t[:, 2], np.unwrap(t[:, 5]), pulses]))
    names = ("record", "t", "depth", "yaw", *(f"T{i}" for i in THRUSTERS))
    source = f"{SOURCE}\nRecords: {', '.join(f'{i} {n}' for i, n in enumerate(RECORDS))}; s, m, rad, us"
    keep("bolt.csv", source, dict(zip(names, np.concatenate(parts).T, strict=True)))


def _picture(seen: Any, ran: Any) -> bytes:
    with theme.style():
        figure = theme.figure(10.5, 2.8)
        for axes, (name, column, label) in zip(
            figure.subplots(1, 4),
            (("yaw_test", "yaw", "yaw [rad]"), ("Yaw_test_3", "yaw", "yaw [rad]"),
             ("Yaw_test_5", "yaw", "yaw [rad]"), ("Depth_test_4", "depth", "depth [m]")),
            strict=True,
        ):  # fmt: skip
            axes.plot(seen[name]["t"], seen[name][column], ".", color=theme.SENSOR, label="measured")
            axes.plot(ran[name]["t"], ran[name][column], color=theme.TRUTH, label="simulated")
            axes.set_xlabel("time [s]")
            axes.set_ylabel(label)
            axes.set_title(name)
        axes.legend()
        picture = theme.as_png(figure)
        plt.close(figure)
    return picture


_ABOUT: Final = """\
Nothing is fitted: mass, volume, inertia, added mass and drag are the maker's (CAD and CFD), thrusters are the
catalogue's T200 with von Benzon's transfer function at 16 V. The simulated vehicle hangs in open water and gets the
recorded pulses; yaw and depth are compared from the record's first. The delay of a steady motion is where its line,
drawn back, meets the start.
"""
_MISSED: Final = """\
What holds are steady motions by strong pulses. The yaw tests were made with the vehicle 6 to 11 cm under the surface,
0.3 m high and thus awash, where thrusters take in air and waves take energy; small pulses (70 to 100 us beside neutral)
that stop and start again every 2.5 s then make half the turn, and a motion needs a second longer to begin. The heave
test begins there too: the vehicle sinks at 0.10 m/s in the first 5 s and at 0.21 m/s below 1 m. Where the thrusters of
the yaw tests sit is known by their radius alone.
"""
