"""Follow a pipeline with a camera."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from typing import Any, Final

import gymnasium
import numpy as np
from numpy.typing import NDArray

from pelagos.envs.sensing import Judgement, SensingTask, measured
from pelagos.envs.tasks.rov import rov
from pelagos.math.so3 import rotate_np
from pelagos.sim.simulation import Simulation

_DEPTH_M: Final = 12.0
_PIPE_M: Final = 0.5  # its diameter
_MIDDLE_M: Final = 0.2  # of the pipe over the bed: it lies a little in the sand
_TOP_M: Final = _MIDDLE_M + _PIPE_M / 2 - _DEPTH_M  # [m], world z
_PATH: Final = np.array([[-6.0, 0.0], [8.0, 1.0], [20.0, 5.0], [34.0, 4.0], [50.0, -3.0]])  # north, west [m]
_SPEED_MPS: Final = 0.4
_ABOVE_M: Final = 2.0  # the pipe's top
_PIXELS: Final = 84
_FOV_DEG: Final = 80.0
_DARK: Final = 0.75  # of the bed's brightness: what is less is pipe


class PipelineFollowing(SensingTask):
    """A BlueROV2 Heavy goes along a pipe on the bed at 0.4 m/s, 2 m above it, by a camera that looks down.

    Actions are surge, sway (0.5 m/s), heave (0.2 m/s) and the rate of turn (0.5 rad/s). The reward of a step is 1 for
    the speed along the pipe, less 0.5 for each metre off its line, metre off the height, and radian off its direction;
    more than 2 m off the line, or 2 m off the height, the episode ends with -5. Seen: the picture, `(84, 84, 3)` uint8,
    its top forward; height over what is below by an altimeter, velocities by DVL, and the rate of turn.
    """

    actions = 4
    rate_hz = 5.0
    seconds = 60.0

    def __init__(self) -> None:
        box = gymnasium.spaces.Box
        self.space = gymnasium.spaces.Dict(
            {
                "camera": box(0, 255, (_PIXELS, _PIXELS, 3), np.uint8),
                "state": box(np.float32(-1e3), np.float32(1e3), (5,), np.float32),
            }
        )

    def scenario(self) -> Mapping[str, Any]:
        """A pipe of four straight pieces on a flat bed of sand, 12 m down in coastal water."""
        pieces = []
        for k, (a, b) in enumerate(itertools.pairwise(_PATH)):
            middle, way = 0.5 * (a + b), b - a
            pieces.append(
                {
                    "shape": "cylinder", "at_m": [*middle.tolist(), _MIDDLE_M - _DEPTH_M],
                    "size_m": [_PIPE_M, _PIPE_M, float(np.hypot(*way))],
                    "orientation_deg": [0.0, 90.0, math.degrees(math.atan2(way[1], way[0]))],
                    "material": "rubber", "label": "pipe", "name": f"pipe{k}",
                }
            )  # fmt: skip
        camera = {
            "type": "camera", "rate_hz": self.rate_hz, "width_px": _PIXELS, "height_px": _PIXELS,
            "horizontal_fov_deg": _FOV_DEG, "orientation_deg": [0.0, 90.0, 0.0], "position_m": [0.0, 0.0, -0.2],
        }  # fmt: skip
        sensors = {name: {"type": name, "rate_hz": self.rate_hz} for name in ("dvl", "altimeter")}
        return {
            "tick_rate_hz": 50,
            "world": {"type": "built", "depth_m": _DEPTH_M, "size_m": [120, 60], "things": pieces},
            "ocean": {"water_type": "1C"},
            "agents": {
                "auv0": {
                    "vehicle": rov(),
                    "control": "velocity",
                    "start": {"position_m": [0.0, 0.0, _TOP_M + _ABOVE_M]},
                    "sensors": {"camera": camera, **sensors},
                }
            },
        }

    def start(self, random: np.random.Generator, sim: Simulation) -> dict[str, Any]:
        """Within a metre of the first piece, 1.5 to 2.5 m above it, the bow along it within 25 degrees."""
        yaw = random.uniform(-0.44, 0.44)
        place = [random.uniform(-3.0, 5.0), random.uniform(-0.8, 0.8), random.uniform(1.5, 2.5) + _TOP_M]
        return {"position": place, "attitude": [math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2)]}

    def command(self, actions: NDArray[np.float64], sim: Simulation) -> NDArray[np.float64]:
        """Velocities, forward-left-up."""
        return np.asarray(actions * np.array([0.5, 0.5, 0.2, 0.5]))

    def observe(self, sim: Simulation, readings: Mapping[str, Any]) -> dict[str, NDArray[Any]]:
        """See the class."""
        over_ground, height = (measured(readings, name, sim.n, k) for name, k in (("dvl", 3), ("altimeter", 1)))
        numbers = [*height.T, *over_ground.T, sim.state[self.agent].angular_velocity[:, 2]]
        return {"camera": readings["camera"].data, "state": np.stack(numbers, axis=1, dtype=np.float32)}

    def judge(self, sim: Simulation, actions: NDArray[np.float64], began: NDArray[np.bool_]) -> Judgement:
        """See the class; distances by the truth."""
        state = sim.state[self.agent]
        off, direction = _line(state.position[:, :2])
        turn = np.abs((state.euler[:, 2] - direction + math.pi) % (2 * math.pi) - math.pi)
        way = rotate_np(state.attitude, state.velocity)
        speed = way[:, 0] * np.cos(direction) + way[:, 1] * np.sin(direction)
        height = np.abs(state.position[:, 2] - _TOP_M - _ABOVE_M)
        out = (off > 2.0) | (height > 2.0)
        along = 1.0 - np.minimum(np.abs(speed - _SPEED_MPS) / _SPEED_MPS, 2.0)
        reward = along - 0.5 * off - 0.5 * height - 0.5 * turn - 5.0 * out
        metrics = {"off_line_m": off, "heading_error_rad": turn, "height_error_m": height, "speed_mps": speed}
        return Judgement(reward, out, metrics)

    def script(self, seen: Mapping[str, NDArray[Any]]) -> NDArray[np.float32]:
        """The baseline: what is darker than the bed, in the upper and in the lower half, is the pipe's line."""
        green = seen["camera"][..., 1].astype(np.float64)
        dark = green < _DARK * np.median(green, axis=(1, 2), keepdims=True)
        metres = seen["state"][:, 0] * 2.0 * math.tan(math.radians(_FOV_DEG / 2)) / _PIXELS  # a pixel, there
        left = (0.5 * (_PIXELS - 1) - np.arange(_PIXELS))[None, None]
        half = _PIXELS // 2
        upper, lower = ((left * d).sum(axis=(1, 2)) / np.maximum(d.sum(axis=(1, 2)), 1) for d in np.split(dark, 2, 1))
        seen_both = np.all([d.any(axis=(1, 2)) for d in np.split(dark, 2, 1)], axis=0)
        offset = np.where(seen_both, 0.5 * (upper + lower) * metres, 0.0)
        turn = np.where(seen_both, np.arctan((upper - lower) / half), 0.0)
        return np.stack(
            [
                np.full(len(turn), _SPEED_MPS / 0.5) * np.cos(turn),
                np.clip(1.2 * offset / 0.5, -1, 1),
                np.clip(2.0 * (_ABOVE_M - seen["state"][:, 0]), -1, 1),
                np.clip(2.0 * turn, -1, 1),
            ],
            axis=1,
        ).astype(np.float32)


def _line(place: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Distance from the nearest piece of the path `(n,)` [m], and that piece's direction, from north to west [rad]."""
    first, way = _PATH[:-1], np.diff(_PATH, axis=0)
    share = np.einsum("nki,ki->nk", place[:, None] - first, way) / np.square(way).sum(axis=1)
    nearest = first + np.clip(share, 0.0, 1.0)[..., None] * way  # (n, k, 2)
    distance = np.linalg.norm(place[:, None] - nearest, axis=-1)
    piece = distance.argmin(axis=1)
    return distance[np.arange(len(place)), piece], np.arctan2(way[:, 1], way[:, 0])[piece]
