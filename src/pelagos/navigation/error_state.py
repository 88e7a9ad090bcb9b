"""Error-state extended Kalman filter of an inertial unit, for many lanes at once.

The nominal state is integrated from specific force and angular rate; the filter estimates its small errors, 22 of them:

    position (world) 0:3, velocity (world) 3:6, attitude (body, R_true = R exp([theta])) 6:9, gyroscope bias 9:12,
    accelerometer bias 12:15, slow error of satellite positions 15:18, offset of the depth 18, magnetometer bias 19:22.

Source: J. Sola, "Quaternion kinematics for the error-state Kalman filter", arXiv 1711.02508, Section 5 (kinematics,
local angular error) and Section 6 (fusing, injection, reset). Slow errors are first-order Gauss-Markov processes:
R. G. Brown and P. Y. C. Hwang, Introduction to Random Signals and Applied Kalman Filtering, 4th ed., 2012, Section 9.3.

Why not a library: FilterPy, the usual one, has not been kept since 2018, and none of those that are (GTSAM, Stone Soup)
filters a fleet of thousands in one call, or keeps its bytes for any number of lanes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.math.constants import GRAVITY
from pelagos.math.rotation import Floats, apply, from_vector, product, skew
from pelagos.math.so3 import matrix_np

SIZE: Final = 22
POSITION: Final = slice(0, 3)
VELOCITY: Final = slice(3, 6)
ATTITUDE: Final = slice(6, 9)
GYROSCOPE: Final = slice(9, 12)
ACCELEROMETER: Final = slice(12, 15)
SATELLITE: Final = slice(15, 18)
DEPTH: Final = slice(18, 19)
MAGNETOMETER: Final = slice(19, 22)


@dataclass(frozen=True)
class InertialNoise:
    """Figures of an inertial unit, as its data sheet gives them.

    Attributes:
        force, rate: densities of white noise [m/s^2/sqrt(Hz)], [rad/s/sqrt(Hz)].
        force_walk, rate_walk: random walk of the biases [m/s^2/sqrt(s)], [rad/s/sqrt(s)].
        force_scale, force_alignment: errors of the specific force by that along the same and along another axis [-].
        scale, alignment: errors of the angle turned about the same and about another axis [-].
    """

    force: float
    rate: float
    force_walk: float
    rate_walk: float
    force_scale: float
    force_alignment: float
    scale: float
    alignment: float


@dataclass(frozen=True)
class SlowNoise:
    """Gauss-Markov errors: standard deviation and correlation time [s] of each of the errors from `SATELLITE` on."""

    std: tuple[float, ...]
    time_s: tuple[float, ...]


@dataclass
class Lanes:
    """The filter's state, one row a lane.

    Attributes:
        position, velocity: `(n, 3)` of the inertial unit, world NWU [m], [m/s].
        attitude: `(n, 4)` body FLU to world.
        gyroscope, accelerometer: `(n, 3)` biases, body [rad/s], [m/s^2].
        slow: `(n, 7)` slow error of satellite positions [m], offset of the depth [m], magnetometer bias [T].
        covariance: `(n, 22, 22)`.
        rate: `(n, 3)` the last angular rate, bias taken off, body [rad/s].
    """

    position: Floats
    velocity: Floats
    attitude: Floats
    gyroscope: Floats
    accelerometer: Floats
    slow: Floats
    covariance: Floats
    rate: Floats

    @classmethod
    def at(cls, position: Floats, velocity: Floats, attitude: Floats, std: Floats) -> Lanes:
        """A start; std: `(22,)` standard deviations of its errors."""
        n = len(position)
        zero = np.zeros((n, 3))
        return cls(
            position.copy(), velocity.copy(), attitude.copy(), zero.copy(), zero.copy(), np.zeros((n, 7)),
            np.tile(np.diag(std**2), (n, 1, 1)), zero.copy(),
        )  # fmt: skip

    @classmethod
    def joined(cls, parts: Sequence[Lanes]) -> Lanes:
        """Lanes one after the other."""
        return cls(**{key: np.concatenate([vars(part)[key] for part in parts]) for key in vars(parts[0])})

    def take(self, lanes: slice | NDArray[np.intp]) -> Lanes:
        """Some lanes, as a copy."""
        return Lanes(**{key: values[lanes].copy() for key, values in vars(self).items()})

    def put(self, lanes: NDArray[np.intp], other: Lanes) -> None:
        """Replace some lanes."""
        for key, values in vars(self).items():
            values[lanes] = vars(other)[key]

    def predict(
        self, force: Floats, rate: Floats, h: float, noise: InertialNoise, slow: SlowNoise, *, samples: int = 1
    ) -> None:
        """Go on by h [s].

        Args:
            force, rate: means of the specific force [m/s^2] and angular rate [rad/s] over so many `samples`, body
                `(n, 3)`. Each is of the end of its part of h; it is the attitude there that turns the force.
            h: step [s].
            noise, slow: figures of the inertial unit, and of slow errors.
            samples: how many.
        """
        turning, push = rate - self.gyroscope, force - self.accelerometer
        self.rate = turning
        middle = 0.5 * (samples + 1) / samples * h
        half = matrix_np(product(self.attitude, from_vector(middle * turning)))
        acceleration = apply(half, push) + np.array([0.0, 0.0, -GRAVITY])
        self.position = self.position + h * self.velocity + 0.5 * h * h * acceleration
        self.velocity = self.velocity + h * acceleration
        self.attitude = product(self.attitude, from_vector(h * turning))
        self.attitude /= np.sqrt((self.attitude**2).sum(axis=-1, keepdims=True))
        keep = np.exp(-h / np.array(slow.time_s))
        self.slow = keep * self.slow
        self._spread(half, push, turning, h, noise, keep, np.array(slow.std))

    def _spread(
        self, half: Floats, push: Floats, turning: Floats, h: float, noise: InertialNoise, keep: Floats, std: Floats
    ) -> None:
        """F P F^T + Q."""
        f = np.tile(np.eye(SIZE), (len(half), 1, 1))
        tilt = -h * (half @ skew(push))
        f[:, POSITION, VELOCITY] = h * np.eye(3)
        f[:, POSITION, ATTITUDE] = 0.5 * h * tilt
        f[:, POSITION, ACCELEROMETER] = -0.5 * h * h * half
        f[:, VELOCITY, ATTITUDE] = tilt
        f[:, VELOCITY, ACCELEROMETER] = -h * half
        f[:, ATTITUDE, ATTITUDE] = matrix_np(from_vector(-h * turning))
        f[:, ATTITUDE, GYROSCOPE] = -h * np.eye(3)
        slow = np.arange(SATELLITE.start, SIZE)
        f[:, slow, slow] = keep
        p = f @ self.covariance @ np.swapaxes(f, 1, 2)
        turned = h * np.abs(turning)
        crossed = turned.sum(axis=-1, keepdims=True) - turned
        # a bias by gravity's share g sin(tilt) grows in variance by its square's derivative while the tilt changes
        tilted = 2 * GRAVITY**2 * np.sqrt(half[:, 2, 0] ** 2 + half[:, 2, 1] ** 2)[:, None] * turned
        roll, pitch = tilted[:, 0], tilted[:, 1]
        along, across = noise.force_scale**2, noise.force_alignment**2
        leaked = [along * pitch + across * roll, along * roll + across * pitch, across * (roll + pitch)]
        d = np.zeros((len(half), SIZE))
        d[:, VELOCITY] = noise.force**2 * h
        d[:, ATTITUDE] = noise.rate**2 * h + noise.scale**2 * turned + noise.alignment**2 * crossed
        d[:, GYROSCOPE] = noise.rate_walk**2 * h
        d[:, ACCELEROMETER] = noise.force_walk**2 * h + np.stack(leaked, axis=-1)
        d[:, slow] = std**2 * (1 - keep**2)
        i = np.arange(SIZE)
        p[:, i, i] += d
        self.covariance = p

    def update(
        self, jacobian: Floats, innovation: Floats, noise: Floats, valid: NDArray[np.bool_], gate: float
    ) -> None:
        """Fuse a measurement of k numbers.

        Args:
            jacobian: `(n, k, 22)`.
            innovation: `(n, k)` measured less expected.
            noise: `(n, k, k)` covariance.
            valid: `(n,)` lanes that have one.
            gate: lanes whose normalised innovation squared is above this many times k refuse it.
        """
        h = np.where(valid[:, None, None], jacobian, 0.0)
        y = np.where(valid[:, None], innovation, 0.0)
        noise = np.where(valid[:, None, None], noise, np.eye(y.shape[1]))
        ph = self.covariance @ np.swapaxes(h, 1, 2)  # (n, 22, k)
        inverse = np.linalg.inv(h @ ph + noise)
        squared = (y[:, None, :] @ inverse @ y[:, :, None])[:, 0, 0]
        use = valid & (squared <= gate * y.shape[1])
        gain = np.where(use[:, None, None], ph @ inverse, 0.0)
        error = (gain @ y[..., None])[..., 0]
        rest = np.eye(SIZE) - gain @ h
        p = rest @ self.covariance @ np.swapaxes(rest, 1, 2) + gain @ noise @ np.swapaxes(gain, 1, 2)  # Joseph's form
        self.covariance = 0.5 * (p + np.swapaxes(p, 1, 2))
        self._inject(error)

    def _inject(self, error: Floats) -> None:
        """Take the errors into the nominal state; the attitude's covariance turns along."""
        self.position = self.position + error[:, POSITION]
        self.velocity = self.velocity + error[:, VELOCITY]
        self.attitude = product(self.attitude, from_vector(error[:, ATTITUDE]))
        self.attitude /= np.sqrt((self.attitude**2).sum(axis=-1, keepdims=True))
        self.gyroscope = self.gyroscope + error[:, GYROSCOPE]
        self.accelerometer = self.accelerometer + error[:, ACCELEROMETER]
        self.slow = self.slow + error[:, SATELLITE.start :]
        g = np.tile(np.eye(SIZE), (len(error), 1, 1))
        g[:, ATTITUDE, ATTITUDE] -= 0.5 * skew(error[:, ATTITUDE])
        self.covariance = g @ self.covariance @ np.swapaxes(g, 1, 2)
