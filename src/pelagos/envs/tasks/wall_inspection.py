"""Inspect a wall with a sonar."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Final

import gymnasium
import numpy as np
from numpy.typing import NDArray

from pelagos.envs.sensing import Judgement, SensingTask, measured
from pelagos.envs.tasks.rov import rov
from pelagos.math.so3 import rotate_np
from pelagos.sensors.sonar.imaging_sonar import ImagingSonarConfig
from pelagos.sim.simulation import Simulation

_STAND_OFF_M: Final = 3.0
_FAN: Final = np.radians(np.linspace(-60.0, 60.0, 13))
_FAR_M: Final = 15.0
_RANGE_M: Final = 12.0  # of the sonar
# Of each piece of the wall: middle north and west [m], and how far it is turned [deg]; 12 m long, they overlap.
_PIECES: Final = ((10.0, -20.0, 8.0), (10.5, -9.0, -6.0), (11.0, 2.0, 10.0), (11.0, 13.0, -8.0), (10.5, 24.0, 5.0))


class WallInspection(SensingTask):
    """A BlueROV2 Heavy goes along a wall westwards at 0.3 m/s, 3 m off, its bow on the wall, by an imaging sonar.

    Actions are surge, sway (0.5 m/s), heave (0.2 m/s) and the rate of turn (0.5 rad/s). The reward of a step is 1 for
    the speed along the wall, less the errors of distance (0.5 a metre) and heading (0.5 a radian); nearer than 0.8 m or
    farther than 10 m the episode ends with -5. Seen: the sonar's picture `(beams, bins)`, and depth and velocities.
    """

    actions = 4
    rate_hz = 5.0
    seconds = 60.0

    def __init__(self, *, beams: int = 64, rays: int = 16, bins: int = 64) -> None:
        self.beams, self.rays, self.bins = beams, rays, bins
        box = gymnasium.spaces.Box
        self.space = gymnasium.spaces.Dict(
            {
                "sonar": box(np.float32(-1e6), np.float32(1e6), (beams, bins), np.float32),
                "state": box(np.float32(-1e3), np.float32(1e3), (6,), np.float32),
            }
        )

    def scenario(self) -> Mapping[str, Any]:
        """A wall of five pieces on a flat bed, 12 m down."""
        things = [
            {
                "shape": "box", "at_m": [x, y, 6.5], "size_m": [1.0, 12.0, 13.0], "on_ground": True,
                "orientation_deg": [0.0, 0.0, turn], "material": "concrete", "label": "wall", "name": f"piece{i}",
            }
            for i, (x, y, turn) in enumerate(_PIECES)
        ]  # fmt: skip
        sonar = {
            "type": "imaging_sonar", "rate_hz": self.rate_hz, "beams": self.beams, "rays_per_beam": self.rays,
            "bins": self.bins, "range_max_m": _RANGE_M, "horizontal_aperture_deg": 90.0,
            "vertical_beamwidth_deg": 12.0,
        }  # fmt: skip
        return {
            "tick_rate_hz": 50,
            "world": {"type": "built", "depth_m": 12.0, "size_m": [80, 80], "things": things},
            "agents": {
                "auv0": {
                    "vehicle": rov(),
                    "control": "velocity",
                    "start": {"position_m": [5.0, 0.0, -6.0]},
                    "sensors": {"sonar": sonar, "dvl": {"type": "dvl", "rate_hz": self.rate_hz}},
                }
            },
        }

    def start(self, random: np.random.Generator, sim: Simulation) -> dict[str, Any]:
        """2 to 5 m off the eastern half of the wall, the bow on it within 30 degrees."""
        yaw = random.uniform(-math.pi / 6, math.pi / 6)
        place = [10.0 - random.uniform(2.5, 5.0), random.uniform(-20.0, 0.0), -random.uniform(4.0, 8.0)]
        return {"position": place, "attitude": [math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2)]}

    def command(self, actions: NDArray[np.float64], sim: Simulation) -> NDArray[np.float64]:
        """Velocities, forward-left-up."""
        return np.asarray(actions * np.array([0.5, 0.5, 0.2, 0.5]))

    def observe(self, sim: Simulation, readings: Mapping[str, Any]) -> dict[str, NDArray[Any]]:
        """The picture as the sonar gives it; depth, velocities by DVL, rate of turn, heading against north."""
        state = sim.state[self.agent]
        seen = measured(readings, "dvl", sim.n, 3)
        yaw = state.euler[:, 2]
        numbers = [state.depth / 10.0, *seen.T, state.angular_velocity[:, 2], np.sin(yaw)]
        return {
            "sonar": readings["sonar"].data.astype(np.float32),
            "state": np.stack(numbers, axis=1, dtype=np.float32),
        }

    def judge(self, sim: Simulation, actions: NDArray[np.float64], began: NDArray[np.bool_]) -> Judgement:
        """See the class; distance and direction of the wall by rays from the vehicle."""
        state = sim.state[self.agent]
        distance, bearing = self._wall(sim)
        west = rotate_np(state.attitude, state.velocity)[:, 1]
        along = 1.0 - np.minimum(np.abs(west - 0.3) / 0.3, 2.0)
        out = (distance < 0.8) | (distance > 10.0) | (state.depth < 1.0)
        reward = along - 0.5 * np.abs(distance - _STAND_OFF_M) - 0.5 * np.abs(bearing) - 5.0 * out
        metrics = {"stand_off_error_m": np.abs(distance - _STAND_OFF_M), "bearing_rad": np.abs(bearing)}
        return Judgement(reward, out, metrics | {"west_mps": west})

    def _wall(self, sim: Simulation) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Distance of the nearest wall ahead [m], and its direction from the bow, to the left [rad]."""
        state = sim.state[self.agent]
        n, yaw = len(state.position), state.euler[:, 2]
        angle = yaw[:, None] + _FAN
        ways = np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=-1).reshape(-1, 3)
        hits = sim.world.cast(np.repeat(state.position, len(_FAN), axis=0), ways, _FAR_M)
        t = np.where(np.asarray(hits.valid), np.asarray(hits.t), _FAR_M).reshape(n, -1)
        nearest = t.argmin(axis=1)
        return t[np.arange(n), nearest], _FAN[nearest]

    def script(self, seen: Mapping[str, NDArray[Any]]) -> NDArray[np.float32]:
        """The baseline: the first strong echo of each beam as a line; its distance and slope steer."""
        ranges = (np.arange(self.bins) + 0.5) * _RANGE_M / self.bins
        top = seen["sonar"].argmax(axis=2)  # (n, beams)
        angle = ImagingSonarConfig(beams=self.beams, horizontal_aperture_deg=90.0).azimuths
        x, y = ranges[top] * np.cos(angle), ranges[top] * np.sin(angle)
        slope = [np.polyfit(b, a, 1) for a, b in zip(x, y, strict=True)]
        found = np.array([[s[0], s[1] * math.cos(math.atan(s[0]))] for s in slope])
        turn = -np.arctan(found[:, 0])
        surge = np.clip(0.8 * (found[:, 1] - _STAND_OFF_M), -0.3, 0.3)
        return np.stack(
            [surge / 0.5, np.full(len(surge), 0.6), np.zeros(len(surge)), np.clip(2.0 * turn, -1, 1)], axis=1
        ).astype(np.float32)
