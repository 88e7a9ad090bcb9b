"""Strip theory: a slender hull's coefficients from the waves about its sections, each in its own plane.

Sections make and scatter waves in two dimensions (`hydro.section`), as if the next section were its own continuation:
N. Salvesen, E. O. Tuck and O. Faltinsen, Trans. SNAME 78:250 (1970), equations 18 to 29. Right for hulls that are long
against beam and draught, in waves that are short against the length; surge is not part of it, long waves radiate too
much, and hulls side by side do not feel each other's waves. Deep water, FRD about an origin at the waterline.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pelagos.hydro.forward_speed import scattered_at_speed, section_motion
from pelagos.hydro.section import SectionRadiation, section_added_mass, section_radiation
from pelagos.math.constants import GRAVITY

Values = NDArray[np.float64]
Waves = NDArray[np.complex128]

TO_FRD = np.array([1.0, -1.0, -1.0])
"""Sway, heave and roll of a section, whose z is upwards, to those of a hull."""


@dataclass(frozen=True)
class Station:
    """A slice of a hull.

    Attributes:
        position: forward of the origin [m].
        width: along the hull [m].
        side: of its middle, to starboard of the origin [m].
        points: `(n, 2)` of the section about its middle, see `section_waves`.
    """

    position: float
    width: float
    side: float
    points: Values


@dataclass(frozen=True)
class Strips:
    """A hull's stations and the waves of their motions.

    Attributes:
        stations: from the stern to the bow.
        omega: frequencies, increasing [rad/s].
        waves: of each station at each frequency.
        infinite: added mass at infinite frequency of each station `(3, 3)` per length and density.
        transom: whether the hull is cut off at the first station's after side.
    """

    stations: tuple[Station, ...]
    omega: Values
    waves: tuple[tuple[SectionRadiation, ...], ...]
    infinite: tuple[Values, ...]
    transom: bool = False

    def added_mass_infinite(self) -> Values:
        """`(6, 6)` over the density."""
        return self._whole(self.infinite).real

    def coefficients(self) -> tuple[Values, Values]:
        """Added mass and damping `(frequencies, 6, 6)` over the density, zero speed."""
        momentum = np.stack([self._whole([w[i].momentum for w in self.waves]) for i in range(len(self.omega))])
        return momentum.real, self.omega[:, None, None] * momentum.imag

    def _whole(self, sections: Sequence[NDArray[np.complexfloating | np.floating]]) -> Waves:
        found = np.zeros((6, 6), complex)
        for station, section in zip(self.stations, sections, strict=True):
            motion = section_motion(station.position, station.side)
            found += station.width * motion.T @ (TO_FRD[:, None] * section * TO_FRD) @ motion
        return found

    @property
    def end(self) -> float:
        """Place of the after end forward of the origin [m]."""
        return self.stations[0].position - self.stations[0].width / 2

    def excitation(self, omega: float, heading: float, speed: float) -> tuple[Waves, Waves]:
        """Force (6) of the pressure in a wave of amplitude 1 m, and of the wave that the hull scatters at a speed.

        Args:
            omega: of the wave as one who stands sees it [rad/s].
            heading: direction that it travels towards, from the bow over starboard [rad].
            speed: ahead [m/s].

        Returns:
            Over the density; amplitudes of exp(i (k . x - omega t)) at the origin.
        """
        k, ahead, aside = omega**2 / GRAVITY, float(np.cos(heading)), float(np.sin(heading))
        met = omega - k * speed * ahead
        pressed, impulse, last = np.zeros(6, complex), np.zeros(6, complex), np.zeros(3, complex)
        for i, station in enumerate(self.stations):
            section = self._at(i, met)
            phase = np.exp(1j * k * (station.position * ahead + station.side * aside))
            motion = section_motion(station.position, station.side)
            y, z = section.middles.T
            pressure = GRAVITY * np.exp(k * z + 1j * k * aside * y) @ section.directions
            scattered = phase * TO_FRD * section.scattered(omega, aside)
            pressed += station.width * motion.T @ (phase * TO_FRD * pressure)
            impulse += station.width * motion.T @ scattered
            if i == 0:
                last = scattered
        transom = (self.end, last) if self.transom else None
        return pressed, scattered_at_speed(-1j * met * impulse, impulse, speed, transom)

    def _at(self, station: int, omega: float) -> SectionRadiation:
        """Waves of a station's motion at a frequency that may be negative: the hull overtakes the wave."""
        w = float(np.clip(abs(omega), self.omega[0], self.omega[-1]))
        above = int(np.clip(np.searchsorted(self.omega, w), 1, len(self.omega) - 1))
        share = (w - self.omega[above - 1]) / (self.omega[above] - self.omega[above - 1])
        low, high = self.waves[station][above - 1], self.waves[station][above]
        potentials = (1 - share) * low.potentials + share * high.potentials
        return replace(low, omega=omega, potentials=potentials.conj() if omega < 0 else potentials)


def strips_of(stations: Sequence[Station], omega: Values, *, transom: bool = False) -> Strips:
    """Waves about a hull's stations at frequencies omega, increasing [rad/s]; equal sections are solved once.

    Raises:
        InputError: see `section_waves`.
    """
    solved: dict[bytes, tuple[tuple[SectionRadiation, ...], Values]] = {}
    for station in stations:
        key = station.points.tobytes()
        if key not in solved:
            waves = tuple(section_radiation(station.points, float(w)) for w in omega)
            solved[key] = waves, section_added_mass(station.points)
    found = [solved[s.points.tobytes()] for s in stations]
    return Strips(
        tuple(stations),
        np.asarray(omega, dtype=np.float64),
        tuple(w for w, _ in found),
        tuple(a for _, a in found),
        transom,
    )
