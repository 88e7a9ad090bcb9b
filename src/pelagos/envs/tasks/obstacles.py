"""Come through a field of pillars with an imaging sonar."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import gymnasium
import numpy as np
from numpy.typing import NDArray

from pelagos.envs.sensing import Judgement, SensingTask, measured
from pelagos.envs.tasks.rov import rov
from pelagos.math.so3 import from_euler, rotate_np
from pelagos.sensors.sonar.imaging_sonar import ImagingSonarConfig
from pelagos.sim.simulation import Simulation

_DEPTH_M: Final = 12.0
_SPEED_MPS: Final = 0.6
_RADIUS_M: Final = 0.5  # of a pillar
_HULL_M: Final = 0.35  # of the vehicle, from its middle
_ROWS, _COLUMNS, _APART_M, _JITTER_M = 7, 15, 4.5, 1.4
_FIRST_M: Final = 5.0  # north, of the first row
_GOAL_M: Final = _FIRST_M + _ROWS * _APART_M
_RANGE_M: Final = 10.0  # of the sonar
_APERTURE_DEG: Final = 120.0
_CLEAR_M: Final = 1.0  # of the script: half the width of the way that it wants to be free
_LOUD: Final = 0.3  # of the script: an echo, in parts of the loudest of the picture's range


class ObstacleAvoidance(SensingTask):
    """A BlueROV2 Heavy goes north through a field of pillars at up to 0.6 m/s, by an imaging sonar that looks ahead.

    Actions are surge (0 to 0.6 m/s), sway (0.3 m/s) and the rate of turn (0.6 rad/s); depth is held. The reward is 1
    for each metre northwards, 10 at the northern edge, and -10 for a collision; both end the episode. Seen: the sonar's
    picture `(beams, bins)`; sine and cosine of the heading, velocities by DVL, and the rate of turn.
    """

    actions = 3
    rate_hz = 5.0
    seconds = 120.0

    def __init__(self, *, beams: int = 48, rays: int = 12, bins: int = 50, world_seed: int = 5) -> None:
        self.beams, self.rays, self.bins = beams, rays, bins
        row, column = (a.ravel() for a in np.mgrid[:_ROWS, :_COLUMNS])
        west = (column - (_COLUMNS - 1) / 2 + 0.5 * (row % 2)) * _APART_M
        shift = np.random.default_rng(world_seed).uniform(-_JITTER_M, _JITTER_M, (len(row), 2))
        self.pillars = np.stack([_FIRST_M + row * _APART_M, west], axis=1) + shift
        box = gymnasium.spaces.Box
        self.space = gymnasium.spaces.Dict(
            {
                "sonar": box(np.float32(-1e6), np.float32(1e6), (beams, bins), np.float32),
                "state": box(np.float32(-1e3), np.float32(1e3), (5,), np.float32),
            }
        )

    def scenario(self) -> Mapping[str, Any]:
        """105 pillars of concrete on a flat bed of silt, 12 m down."""
        things = [
            {
                "shape": "cylinder", "at_m": [float(x), float(y), -_DEPTH_M / 2], "name": f"pillar{i}",
                "size_m": [2 * _RADIUS_M, 2 * _RADIUS_M, _DEPTH_M], "material": "concrete", "label": "piling",
            }
            for i, (x, y) in enumerate(self.pillars)
        ]  # fmt: skip
        sonar = {
            "type": "imaging_sonar", "rate_hz": self.rate_hz, "beams": self.beams, "rays_per_beam": self.rays,
            "bins": self.bins, "range_max_m": _RANGE_M, "horizontal_aperture_deg": _APERTURE_DEG,
            "vertical_beamwidth_deg": 12.0,
        }  # fmt: skip
        return {
            "tick_rate_hz": 50,
            "world": {"type": "built", "depth_m": _DEPTH_M, "size_m": [140, 120], "things": things},
            "agents": {
                "auv0": {
                    "vehicle": rov(),
                    "control": "velocity",
                    "start": {"position_m": [0.0, 0.0, -_DEPTH_M / 2]},
                    "sensors": {"sonar": sonar, "dvl": {"type": "dvl", "rate_hz": self.rate_hz}},
                }
            },
        }

    def start(self, random: np.random.Generator, sim: Simulation) -> dict[str, Any]:
        """South of the field, within 12 m of its middle, the bow north within 30 degrees."""
        attitude = [float(c) for c in from_euler(0.0, 0.0, random.uniform(-0.5, 0.5))]
        place = [random.uniform(-2.0, 1.0), random.uniform(-12.0, 12.0), -_DEPTH_M / 2 + random.uniform(-1.0, 1.0)]
        return {"position": place, "attitude": attitude}

    def command(self, actions: NDArray[np.float64], sim: Simulation) -> NDArray[np.float64]:
        """Velocities, forward-left-up, and the rate of turn."""
        surge = 0.5 * (1.0 + actions[:, 0]) * _SPEED_MPS
        return np.stack([surge, 0.3 * actions[:, 1], np.zeros_like(surge), 0.6 * actions[:, 2]], axis=1)

    def observe(self, sim: Simulation, readings: Mapping[str, Any]) -> dict[str, NDArray[Any]]:
        """See the class."""
        state, way = sim.state[self.agent], measured(readings, "dvl", sim.n, 2)
        yaw = state.euler[:, 2]
        numbers = [np.sin(yaw), np.cos(yaw), *way.T, state.angular_velocity[:, 2]]
        return {
            "sonar": readings["sonar"].data.astype(np.float32),
            "state": np.stack(numbers, axis=1, dtype=np.float32),
        }

    def judge(self, sim: Simulation, actions: NDArray[np.float64], began: NDArray[np.bool_]) -> Judgement:
        """See the class; distances by the truth."""
        state = sim.state[self.agent]
        apart = np.linalg.norm(state.position[:, None, :2] - self.pillars, axis=-1).min(axis=1) - _RADIUS_M
        north = rotate_np(state.attitude, state.velocity)[:, 0]
        struck, there = apart < _HULL_M, state.position[:, 0] > _GOAL_M
        reward = north / self.rate_hz - 10.0 * struck + 10.0 * (there & ~struck)
        metrics = {"collided": struck * 1.0, "through": (there & ~struck) * 1.0, "north_m": state.position[:, 0]}
        return Judgement(reward, struck | there, metrics | {"clearance_m": apart})

    def script(self, seen: Mapping[str, NDArray[Any]]) -> NDArray[np.float32]:
        """The baseline: the way nearest to north on which no echo lies, after J. Borenstein and Y. Koren, "The vector
        field histogram", IEEE Trans. Robotics and Automation 7 (1991), doi 10.1109/70.88137.
        """
        picture = seen["sonar"].astype(np.float64)
        ranges = (np.arange(self.bins) + 0.5) * _RANGE_M / self.bins
        config = ImagingSonarConfig(beams=self.beams, horizontal_aperture_deg=_APERTURE_DEG)
        low, high = np.median(picture, axis=(1, 2), keepdims=True), picture.max(axis=(1, 2), keepdims=True)
        echo = picture > low + _LOUD * (high - low)
        nearest = np.where(echo.any(axis=2), ranges[echo.argmax(axis=2)], _RANGE_M)  # (n, beams)
        ways = np.radians(np.linspace(-55.0, 55.0, 45))
        aside = config.azimuths - ways[:, None]  # (ways, beams)
        within = (np.abs(np.sin(aside)) * nearest[:, None] < _CLEAR_M) & (np.cos(aside) > 0)
        free = np.where(within, nearest[:, None], _RANGE_M).min(axis=2)  # (n, ways)
        north = -np.arctan2(seen["state"][:, 0], seen["state"][:, 1])  # from the bow, to the left
        cost = np.abs(ways - north[:, None]) + 0.15 * np.abs(ways) + 2.0 * np.maximum(4.0 - free, 0.0)
        best = cost.argmin(axis=1)
        turn, room = ways[best], free[np.arange(len(best)), best]
        surge = np.clip(0.4 * (room - 1.0), 0.1, 1.0) * np.cos(turn) ** 2
        return np.stack([2.0 * surge - 1.0, np.clip(turn, -1, 1), np.clip(2.5 * turn, -1, 1)], axis=1).astype(
            np.float32
        )
