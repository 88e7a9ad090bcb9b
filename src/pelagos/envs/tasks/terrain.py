"""Follow the terrain with an altimeter."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Final

import gymnasium
import numpy as np
from numpy.typing import NDArray

from pelagos.envs.sensing import Judgement, SensingTask, measured
from pelagos.math.so3 import from_euler
from pelagos.sim.simulation import Simulation

_HEIGHT_M: Final = 4.0  # over ground, to be kept
_LOWEST_M: Final = 1.0
_HIGHEST_M: Final = 12.0
_FIN_RAD: Final = math.radians(15.0)
_RPM: Final = 1000.0
_AHEAD_DEG: Final = 50.0  # of the second altimeter, from straight down towards the bow
_RANGE_M: Final = 30.0
_LENGTH_M: Final = 500.0


class TerrainFollowing(SensingTask):
    """A REMUS 100 goes north over ridges and keeps 4 m of height by two altimeters, one down and one obliquely ahead.

    Actions are rudder and stern plane, 15 degrees each way; the propeller turns steadily. The reward of a step falls
    from 1 with the error of the height, less 0.3 for each radian off north and 0.02 for full fins; below 1 m, above
    12 m or beyond the ground the episode ends with -10. Seen: both ranges (30 m where there is no echo), heading,
    pitch, their rates, and surge and heave by DVL.
    """

    actions = 2
    rate_hz = 5.0
    seconds = 100.0

    def __init__(self, *, relief_m: float = 6.0, wavelength_m: float = 150.0, world_seed: int = 3) -> None:
        self.relief_m, self.wavelength_m, self.world_seed = relief_m, wavelength_m, world_seed
        self.space = gymnasium.spaces.Dict(
            {"state": gymnasium.spaces.Box(np.float32(-1e3), np.float32(1e3), (8,), np.float32)}
        )

    def scenario(self) -> Mapping[str, Any]:
        """Generated ground of 500 m x 240 m, 40 m down on average."""
        down = {"type": "altimeter", "rate_hz": self.rate_hz, "range_max_m": _RANGE_M}
        ahead = {**down, "orientation_deg": [0.0, -_AHEAD_DEG, 0.0]}
        return {
            "tick_rate_hz": 50,
            "world": {
                "type": "generated", "seed": self.world_seed, "size_m": [_LENGTH_M, 240], "depth_m": 40, "grid_m": 2,
                "terrain": {
                    "kind": "dunes", "relief_m": self.relief_m, "wavelength_m": self.wavelength_m, "heading_deg": 20,
                },
            },
            "agents": {
                "auv0": {
                    "vehicle": "remus100",
                    "control": "actuators",
                    "start": {"position_m": [0.0, 0.0], "altitude_m": _HEIGHT_M, "speed_mps": 1.2},
                    "sensors": {"down": down, "ahead": ahead, "dvl": {"type": "dvl", "rate_hz": self.rate_hz}},
                }
            },
        }  # fmt: skip

    def start(self, random: np.random.Generator, sim: Simulation) -> dict[str, Any]:
        """Anywhere in the south, 3 to 6 m over ground, under way."""
        x, y = random.uniform(-230.0, -100.0), random.uniform(-90.0, 90.0)
        ground = float(sim.world.height(np.array([x]), np.array([y]))[0])
        attitude = [float(c) for c in from_euler(0.0, 0.0, random.uniform(-0.2, 0.2))]
        place = [x, y, ground + random.uniform(3.0, 6.0)]
        return {"position": place, "attitude": attitude, "velocity": [1.2, 0.0, 0.0]}

    def command(self, actions: NDArray[np.float64], sim: Simulation) -> NDArray[np.float64]:
        """Fins, and a steady propeller."""
        return np.concatenate([_FIN_RAD * actions, np.full((len(actions), 1), _RPM)], axis=1)

    def observe(self, sim: Simulation, readings: Mapping[str, Any]) -> dict[str, NDArray[Any]]:
        """See the class."""
        state = sim.state[self.agent]
        ranges = [measured(readings, name, sim.n, 1, otherwise=_RANGE_M)[:, 0] for name in ("down", "ahead")]
        way = measured(readings, "dvl", sim.n, 3)
        _, pitch, yaw = state.euler.T
        numbers = [*ranges, yaw, pitch, *state.angular_velocity[:, 1:].T, way[:, 0], way[:, 2]]
        return {"state": np.stack(numbers, axis=1, dtype=np.float32)}

    def judge(self, sim: Simulation, actions: NDArray[np.float64], began: NDArray[np.bool_]) -> Judgement:
        """See the class; heights by the truth."""
        state = sim.state[self.agent]
        place, turned = state.position, np.abs(state.euler[:, 2])
        height = place[:, 2] - np.asarray(sim.world.height(place[:, 0], place[:, 1]))
        height = np.where(np.isfinite(height), height, _HIGHEST_M)  # beyond the edge there is no ground
        error = np.abs(height - _HEIGHT_M)
        out = (height < _LOWEST_M) | (height >= _HIGHEST_M)
        fins = np.square(actions).sum(axis=1)
        reward = np.exp(-0.5 * error) - 0.3 * turned - 0.02 * fins - 10.0 * out
        metrics = {"height_error_m": error, "heading_error_rad": turned, "north_m": place[:, 0]}
        return Judgement(reward, out, metrics)

    def script(self, seen: Mapping[str, NDArray[Any]]) -> NDArray[np.float32]:
        """The baseline: pitch by the slope between both echoes and the error of the height, with rate feedback."""
        down, ahead, yaw, pitch, pitch_rate, yaw_rate, *_ = seen["state"].astype(np.float64).T
        bearing = math.radians(_AHEAD_DEG) - pitch  # of the beam ahead, from straight down
        below, coming = down * np.cos(pitch), ahead * np.cos(bearing)
        slope = np.arctan2(coming - below, ahead * np.sin(bearing))
        slope = np.where((ahead < _RANGE_M) & (down < _RANGE_M), slope, 0.0)
        wanted = np.clip(0.9 * slope + 0.1 * (below - _HEIGHT_M), -0.5, 0.5)  # bow down to go deeper
        plane, rudder = 3.0 * (wanted - pitch) - 2.0 * pitch_rate, 2.0 * yaw + 2.0 * yaw_rate
        return np.asarray(np.clip(np.stack([rudder, plane], axis=1), -1, 1), dtype=np.float32)
