"""Speed ahead in radiation and diffraction of a slender hull: strip theory's terms, in frequency and in time.

N. Salvesen, E. O. Tuck and O. Faltinsen, "Ship motions and sea loads", Trans. SNAME 78:250 (1970), below STF70. Heave
w and sway v of a hull that moves at U are those past its own axes, w = dz/dt + U pitch and v = dy/dt - U yaw. The water
that goes along has the momentum P = (A + B / (i omega)) nu, and the load is what its change demands, axes that move:

    force = -dP/dt,   pitch moment = -dP5/dt + U P3,   yaw moment = -dP6/dt - U P2

(M. M. Munk, NACA Report 184, 1924, with a momentum that remembers: T. F. Ogilvie, 5th Symp. Naval Hydrodynamics, 1964).
Written for motions z and pitch instead of w, these are the terms of STF70, Table 1, one by one. An end that is cut off
(a transom) leaves its section's momentum m to the water behind: U m is lost a second, at the section's place.

FRD about an origin at the waterline; motions and forces of exp(i omega t), omega of encounter. Slender hulls, Froude
numbers up to 0.4, omega U / g above 1/4; surge is not part of strip theory.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Values = NDArray[np.float64]
Waves = NDArray[np.complex128]

SLOPE = np.zeros((6, 6))
"""Velocity past the hull's axes over U and angle `(6, 6)`: heave by pitch, sway by minus yaw."""
SLOPE[2, 4], SLOPE[1, 5] = 1.0, -1.0


@dataclass(frozen=True)
class Transom:
    """The section at which a hull is cut off astern, at one frequency.

    Attributes:
        position: forward of the origin [m], negative.
        momentum: added mass plus damping over (i omega), sway, heave and roll per length `(3, 3)`, FRD [kg/m], [kg],
            [kg m].
    """

    position: float
    momentum: Waves


def section_motion(position: float, side: float = 0.0) -> Values:
    """Motion (3) of a section in sway, heave and roll by that of the hull `(3, 6)`, FRD; its position forward, and its
    middle to starboard [m].
    """
    motion = np.zeros((3, 6))
    motion[1, 3] = side
    motion[0, 1] = motion[1, 2] = motion[2, 3] = 1.0
    motion[0, 5], motion[1, 4] = position, -position
    return motion


def at_speed(
    added: ArrayLike, damping: ArrayLike, omega: float, speed: float, transom: Transom | None = None
) -> tuple[Values, Values]:
    """Added mass and damping `(6, 6)` of motions at a speed: STF70, Table 1, and its lateral part.

    Args:
        added, damping: at zero speed and the frequency of encounter `(6, 6)`.
        omega: of encounter, positive [rad/s].
        speed: U ahead [m/s].
        transom: counted where the hull goes ahead.
    """
    lag = speed / (1j * omega)
    momentum = np.asarray(added) + np.asarray(damping) / (1j * omega)
    past = np.eye(6) + lag * SLOPE
    found = (np.eye(6) - lag * SLOPE.T) @ momentum @ past
    if transom is not None and speed > 0:
        section = section_motion(transom.position)
        found = found + lag * section.T @ transom.momentum @ section @ past
    return np.asarray(found.real), np.asarray(-omega * found.imag)


def scattered_at_speed(
    force: ArrayLike, impulse: ArrayLike, speed: float, transom: tuple[float, ArrayLike] | None = None
) -> Waves:
    """Force (6) of the scattered wave at a speed: STF70, equations 24 to 29, the part of h.

    Args:
        force: (6) of strips that each scatter by themselves at the frequency of encounter.
        impulse: its integral over time (6).
        speed: U ahead [m/s].
        transom: its place forward of the origin [m], and the impulse per length of its section (3); counted where the
            hull goes ahead.
    """
    impulse = np.asarray(impulse)
    found = np.asarray(force) - speed * SLOPE.T @ impulse
    if transom is not None and speed > 0:
        position, lost = transom
        found = found + speed * section_motion(position).T @ np.asarray(lost)
    return np.asarray(found)
