"""Linear waves about a floating section: added mass, damping and excitation in two dimensions, in any depth.

Green's third identity with sources on every boundary but the bottom, which their images across it are: the hull, the
free surface on both sides of it, and an end on each side at which waves only leave. Potentials are constant on straight
panels, whose integrals are exact. There are no irregular frequencies, since the water's surface inside of the hull is
no boundary. R. W. Yeung, A hybrid integral-equation method for time-harmonic free-surface flow, Proc. 1st Int. Conf.
Numerical Ship Hydrodynamics, 1975; equations of motion as J. N. Newman, Marine Hydrodynamics, 1977, Sections 6.15-19.

Axes of a section: y to starboard, z upwards from the waterline, roll from y to z; motions are sway, heave and roll.
Amplitudes are complex, of exp(-i omega t); forces are per metre of length and over the water's density.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pelagos.errors import InputError
from pelagos.math.constants import GRAVITY
from pelagos.math.dispersion import wavenumber

Values = NDArray[np.float64]
Waves = NDArray[np.complex128]

_PER_WAVE: Final = 40  # panels of the surface to a wavelength
_GROWTH: Final = 1.08  # of panels away from the hull
_ENDS: Final = 3.0  # depths from the hull to the ends: what does not travel has died away to 1e-3 of itself
_DEEP: Final = 0.75  # wavelengths: tanh(k h) is 0.9998

MOST: Final = 4000
"""Panels of a section's surroundings at most: some 10 s and 1 GB."""
BODY, SURFACE, END = range(3)


@dataclass(frozen=True)
class SectionWaves:
    """Waves about a section at one frequency.

    Attributes:
        omega: [rad/s].
        wavenumber: [1/m].
        added_mass, damping: `(3, 3)` per length and density, sway, heave and roll about the waterline's middle.
        froude_krylov, diffraction: `(3,)` forces per length, density and amplitude, of a wave that travels to
            starboard: of its pressure as if there were no hull, and of what the hull makes of it.
        reflected, transmitted: amplitudes to port and to starboard over that of the wave, a hull that is held.
        radiated: `(2, 3)` amplitudes to port and to starboard of the waves of a velocity of 1 m/s or 1 rad/s.
        group_velocity: [m/s].
    """

    omega: float
    wavenumber: float
    added_mass: Values
    damping: Values
    froude_krylov: Waves
    diffraction: Waves
    reflected: complex
    transmitted: complex
    radiated: Waves
    group_velocity: float

    @property
    def excitation(self) -> Waves:
        """`(3,)` both parts of the force of a wave that travels to starboard."""
        return self.froude_krylov + self.diffraction


@dataclass(frozen=True)
class SectionRadiation:
    """Waves of a section's own motions at one frequency, and their potentials on it.

    Attributes:
        omega: [rad/s].
        middles: `(n, 2)` of the hull's panels, y and z [m].
        directions: `(n, 3)` their normals into the hull in sway, heave and roll, times their lengths.
        potentials: `(n, 3)` of a velocity of 1 m/s or 1 rad/s.
    """

    omega: float
    middles: Values
    directions: Values
    potentials: Waves

    @property
    def momentum(self) -> Waves:
        """Added mass and i / omega of the damping `(3, 3)` per length and density."""
        return self.directions.T @ self.potentials

    def scattered(self, omega: float, side: float) -> Waves:
        """Impulse (3) of the force that a hull, held, exerts by scattering a wave of amplitude 1 m in deep water.

        By Green's theorem from the potentials of its own motion (M. D. Haskind 1957; STF70 equations 26 to 28): the
        wave's own motion past the section is in them. The force is -i times the frequency of encounter, which is this
        object's, times the impulse.

        Args:
            omega: of the wave as one who stands sees it [rad/s].
            side: sine of its direction, to starboard.
        """
        k = omega**2 / GRAVITY
        y, z = self.middles.T
        along = self.directions[:, 1] + 1j * side * self.directions[:, 0]
        return np.asarray(-1j * omega * self.potentials.T @ (along * np.exp(k * z + 1j * k * side * y)))


def section_radiation(points: ArrayLike, omega: float) -> SectionRadiation:
    """Waves of a section's own motions in deep water.

    Args:
        points, omega: see `section_waves`.

    Raises:
        InputError: see `section_waves`.
    """
    tank, k = _tank_about(points, omega, None)
    potentials, _ = tank.solve(omega, k)
    on = tank.kind == BODY
    directions = tank.lengths[on, None] * tank.directions[on]
    return SectionRadiation(omega, tank.middles[on], directions, potentials[on, :3])


def section_waves(points: ArrayLike, omega: float, *, depth: float | None = None) -> SectionWaves:
    """Waves about a section that floats at the surface.

    Args:
        points: `(n, 2)` y and z [m] along the wet hull, from the waterline at port under the keel to that at starboard;
            each pair of neighbours is a panel: 60 or more give 1 %.
        omega: of the waves [rad/s].
        depth: of the water [m]; None for deep water.

    Raises:
        InputError: a section that does not begin and end at the waterline or leaves the water, or a frequency or depth
            that cannot be, or waves so short that they need more than `MOST` panels.
    """
    tank, k = _tank_about(points, omega, depth)
    level = tank.level
    potentials, wave = tank.solve(omega, k)
    force = tank.lengths[:, None] * tank.directions
    inertia = force.T @ potentials[:, :3]
    kh = 2 * k * level
    away = 1j * omega / GRAVITY * tank.travelling(potentials, k)
    return SectionWaves(
        omega=omega,
        wavenumber=k,
        added_mass=inertia.real,
        damping=omega * inertia.imag,
        froude_krylov=1j * omega * force.T @ wave,
        diffraction=1j * omega * force.T @ potentials[:, 3],
        reflected=complex(away[0, 3]),
        transmitted=complex(1 + away[1, 3]),
        radiated=away[:, :3],
        group_velocity=0.5 * omega / k * (1 + kh / np.sinh(min(kh, 300.0))),
    )


def _tank_about(points: ArrayLike, omega: float, depth: float | None) -> tuple[_Tank, float]:
    """The tank about a section, and the number of its waves [1/m]."""
    hull = _checked(points, depth)
    if not (np.isfinite(omega) and omega > 0):
        raise InputError(f"omega must be a positive number [rad/s], not {omega:g}; for infinity: section_added_mass")
    low, size = -float(hull[:, 1].min()), float(np.abs(hull).max())
    deep = 2 * np.pi * GRAVITY / omega**2
    level = max(_DEEP * deep, 6 * max(low, size))
    level = level if depth is None else min(depth, level)
    k = float(wavenumber(np.array(omega), level))
    return _Tank.around(hull, level, 2 * np.pi / k / _PER_WAVE), k


def section_added_mass(points: ArrayLike, *, depth: float | None = None) -> Values:
    """Added mass `(3, 3)` at infinite frequency, per length and density, about the waterline's middle.

    Args:
        points, depth: see `section_waves`.

    Raises:
        InputError: see `section_waves`.
    """
    hull = _checked(points, depth)
    deep = 20 * float(np.abs(hull).max())  # the bottom's image adds some (size / depth)^2 / 4
    tank = _Tank.around(hull, deep if depth is None else min(depth, deep), deep / 2 / _PER_WAVE)
    return (tank.lengths[:, None] * tank.directions).T @ tank.solve_at_infinity()


@dataclass(frozen=True)
class _Tank:
    """Straight panels around the water, which lies to their left.

    Attributes:
        starts, ends: `(n, 2)` [m].
        kind: `(n,)` BODY, SURFACE or END.
        level: depth of the water [m].
        reach: of the ends [m].
    """

    starts: Values
    ends: Values
    kind: NDArray[np.int64]
    level: float
    reach: float

    @classmethod
    def around(cls, hull: Values, level: float, largest: float) -> _Tank:
        """A tank about a hull, with panels of the surface that grow to the `largest` [m].

        Raises:
            InputError: it would have more than `MOST` panels.
        """
        reach = float(np.abs(hull[:, 0]).max()) + _ENDS * level
        if 2 * reach / largest > MOST:
            waves, size = _PER_WAVE * largest, float(np.abs(hull).max())
            text = f"waves of {waves:.3g} m about a section of {size:.3g} m need more than {MOST} panels"
            raise InputError(f"{text}; take a lower omega: beyond it added mass is that of section_added_mass")
        starboard = _surface(float(hull[-1, 0]), float(np.hypot(*(hull[-1] - hull[-2]))), reach, largest)
        port = _surface(-float(hull[0, 0]), float(np.hypot(*(hull[1] - hull[0]))), reach, largest) * [-1, 1]
        count = max(24, int(np.ceil(level / largest / 2)))
        z = -level * (1 - np.cos(np.linspace(0, np.pi / 2, count + 1)))  # finest at the surface
        end = np.stack([np.full_like(z, reach), z], axis=-1)
        lines = [starboard[::-1], hull[::-1], port, end[::-1], end * [-1, 1]]
        kinds = [SURFACE, BODY, SURFACE, END, END]
        return cls(
            np.concatenate([line[:-1] for line in lines]),
            np.concatenate([line[1:] for line in lines]),
            np.concatenate([np.full(len(line) - 1, kind) for line, kind in zip(lines, kinds, strict=True)]),
            level,
            reach,
        )

    @cached_property
    def lengths(self) -> Values:
        """`(n,)` [m]."""
        return np.asarray(np.hypot(*(self.ends - self.starts).T))

    @cached_property
    def middles(self) -> Values:
        """`(n, 2)` [m]."""
        return 0.5 * (self.starts + self.ends)

    @cached_property
    def normals(self) -> Values:
        """`(n, 2)` out of the water."""
        along = self.ends - self.starts
        return np.asarray(np.stack([along[:, 1], -along[:, 0]], axis=-1) / self.lengths[:, None])

    @cached_property
    def directions(self) -> Values:
        """`(n, 3)` normals of the hull in sway, heave and roll; 0 elsewhere."""
        (y, z), (ny, nz) = self.middles.T, self.normals.T
        return np.asarray(np.stack([ny, nz, y * nz - z * ny], axis=-1) * (self.kind == BODY)[:, None])

    @cached_property
    def integrals(self) -> tuple[Values, Values]:
        """Of ln r and of its slope along the normal over each panel and its image, at each middle `(n, n)`."""
        single, double = _line_integrals(self.middles, self.starts, self.ends)
        np.fill_diagonal(double, 0.0)
        across, below = np.array([1.0, -1.0]), np.array([0.0, -2 * self.level])
        image = _line_integrals(self.middles, self.ends * across + below, self.starts * across + below)
        return single + image[0], double + image[1]

    def solve(self, omega: float, k: float) -> tuple[Waves, Waves]:
        """Potentials at the panels `(n, 4)` of sway, heave, roll and diffraction, and that of the wave `(n,)`."""
        single, double = self.integrals
        slope = np.select([self.kind == SURFACE, self.kind == END], [omega**2 / GRAVITY + 0j, 1j * k], 0j)
        wave, through = self._wave(omega, k)
        given = np.concatenate([self.directions, -np.where(self.kind == BODY, through, 0)[:, None]], axis=1)
        matrix = np.pi * np.eye(len(slope)) - double + single * slope
        return np.linalg.solve(matrix, -single @ given), wave

    def solve_at_infinity(self) -> Values:
        """Potentials of sway, heave and roll `(n, 3)` where waves are infinitely short: none at the surface."""
        single, double = self.integrals
        still = self.kind != BODY  # there the slope is unknown instead of the potential
        matrix = np.where(still, single, np.pi * np.eye(len(still)) - double)
        found = np.linalg.solve(matrix, -single @ self.directions)
        return np.asarray(np.where(still[:, None], 0.0, found))

    def travelling(self, potentials: Waves, k: float) -> Waves:
        """Potentials at the surface `(2, m)` of the waves that leave to port and to starboard, as if from the middle:
        the end's potentials without what does not travel.
        """
        profile = np.cosh(k * (self.middles[:, 1] + self.level)) / np.cosh(k * self.level) * self.lengths
        found = []
        for side in (-1, 1):
            end = (self.kind == END) & (np.sign(self.middles[:, 0]) == side)
            weight = profile[end]
            share = weight @ potentials[end] / (weight**2 / self.lengths[end]).sum()
            found.append(share * np.exp(-1j * k * self.reach))
        return np.array(found)

    def _wave(self, omega: float, k: float) -> tuple[Waves, Waves]:
        """Potential of a wave of amplitude 1 m to starboard, and its slope along the normals."""
        y, z = self.middles.T
        rise = k * (z + self.level)
        scale = -1j * GRAVITY / omega / np.cosh(k * self.level) * np.exp(1j * k * y)
        across, up = self.normals.T
        return scale * np.cosh(rise), scale * k * (1j * np.cosh(rise) * across + np.sinh(rise) * up)


def _surface(edge: float, first: float, reach: float, largest: float) -> Values:
    """Corners `(n, 2)` of the water's surface from a hull's edge outwards, panels that grow from the `first` [m]."""
    sizes, left = [first], reach - edge - first
    while left > 0:
        sizes.append(min(_GROWTH * sizes[-1], max(largest, first)))
        left -= sizes[-1]
    along = np.cumsum([0.0, *sizes])
    x = edge + along * ((reach - edge) / along[-1])
    return np.stack([x, 0 * x], axis=-1)


def _line_integrals(points: Values, starts: Values, ends: Values) -> tuple[Values, Values]:
    """Integrals over straight lines of ln r, and of its slope along the lines' right-hand normal, `(points, lines)`."""
    along = ends - starts
    length = np.hypot(*along.T)
    tangent = along / length[:, None]
    from_start = points[:, None] - starts
    x = np.einsum("pli,li->pl", from_start, tangent)
    y = from_start[..., 0] * tangent[:, 1] - from_start[..., 1] * tangent[:, 0]
    rest = x - length
    near, far = (np.where(r > 0, r, 1.0) for r in (x * x + y * y, rest * rest + y * y))
    angle = np.arctan2(length * y, x * rest + y * y)
    single = 0.5 * (x * np.log(near) - rest * np.log(far)) - length + y * angle
    return single, -angle


def _checked(points: Any, depth: float | None) -> Values:
    hull = np.asarray(points, dtype=np.float64)
    if hull.ndim != 2 or hull.shape[1] != 2 or len(hull) < 9 or not np.isfinite(hull).all():
        raise InputError(f"a section must be at least 9 finite points (n, 2), y and z [m], not {hull.shape}")
    size = np.abs(hull).max()
    if np.abs(hull[[0, -1], 1]).max() > 1e-6 * size or hull[0, 0] >= hull[-1, 0]:
        given = f"not from {hull[0]} to {hull[-1]}"
        raise InputError(f"a section must go from the waterline (z = 0) at port to that at starboard, {given}")
    if (hull[1:-1, 1] >= 0).any() or (np.hypot(*np.diff(hull, axis=0).T) <= 0).any():
        raise InputError("between its ends a section must be in the water (z < 0), without a point twice")
    if depth is not None and not depth > -hull[:, 1].min():
        raise InputError(f"depth must be more than the draught ({-hull[:, 1].min():g} m), not {depth:g} m")
    return hull
