"""Roll damping of ships by Ikeda's method, by sections: friction, waves, eddies, bilge keels, and what speed does.

Y. Ikeda, Y. Himeno, N. Tanaka, On eddy making component of roll damping force on naked hull, J. Soc. Naval Arch. Japan
142:54 (1977), whose equation numbers are given, and Components of roll damping of ship at forward speed, 143:113
(1978), doi 10.2534/jjasnaoe1968.1978.113; Y. Himeno, Prediction of ship roll damping: a state of the art, University of
Michigan 239 (1981); ITTC procedure 7.5-02-07-04.5 (2011), 2.2. Waves are those of strip theory about the sections
(`hydro.section`), keels those of `hydro.bilge_keel`, lift is `roll_damping.roll_lift`.

The eddies' coefficients were fitted to forced rolls of two-dimensional cylinders with rounded bilges and to sections of
ships. They hang on the area coefficient: close to 1 it says how sharp the bilge is, and from 0.997 to 0.998 they grow
by two thirds.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos.errors import InputError
from pelagos.hydro.bilge_keel import Bilge, keel_force_damping, keel_pressure_damping
from pelagos.hydro.lewis import LewisForm, lewis_form
from pelagos.hydro.roll_damping import AMPLITUDES, VISCOSITY, linear_and_quadratic
from pelagos.hydro.section import section_radiation
from pelagos.jit import Array

Values = NDArray[np.float64]

_PANELS: Final = 60  # of a Lewis form: 1 % of its waves, see `hydro.section`


@dataclass(frozen=True)
class RollSection:
    """A slice of a ship.

    Attributes:
        position: forward of the origin [m].
        width: length of the ship that it stands for [m].
        beam: at the waterline [m].
        draught: [m].
        area: under water [m^2].
        bilge_radius: [m]; None: the one that beam, draught and area leave a flat bottom and upright sides.
        points: `(n, 2)` y and z [m] from the waterline at port to that at starboard; None: those of its Lewis form.
    """

    position: float
    width: float
    beam: float
    draught: float
    area: float
    bilge_radius: float | None = None
    points: tuple[tuple[float, float], ...] | None = None

    @property
    def ratio(self) -> float:
        """Half the beam over the draught, H0 [-]."""
        return self.beam / 2 / self.draught

    @property
    def fullness(self) -> float:
        """Area coefficient, sigma [-]."""
        return self.area / (self.beam * self.draught)

    @property
    def radius(self) -> float:
        """Of the bilge [m], at most the draught and half the beam (ITTC 2.2.5.1)."""
        if self.bilge_radius is not None:
            return self.bilge_radius
        free = 2 * self.draught * np.sqrt(self.ratio * (1 - self.fullness) / (4 - np.pi))
        return float(min(free, self.draught, self.beam / 2))

    def below(self, depth: float) -> RollSection:
        """The part below a `depth` [m] as if the waterline lay there (equation A-1); the sides are taken as upright.

        Raises:
            InputError: nothing of it is left.
        """
        draught, area = self.draught - depth, self.area - depth * self.beam
        if draught <= 0 or area <= 0:
            raise InputError(
                f"{self.name} has {self.area:.4g} m^2 in a draught of {self.draught:g} m: the roll axis, {depth:g} m "
                "deep, leaves nothing below it; leave this section out"
            )
        return replace(self, draught=draught, area=area)

    @property
    def name(self) -> str:
        """For messages."""
        return f"the section at x = {self.position:g} m"


@dataclass(frozen=True)
class RollSections:
    """A ship by its sections, whose damping is asked for at one frequency.

    Attributes:
        sections: from the stern to the bow.
        length, beam, draught: of the ship [m].
        volume: displaced [m^3].
        depth_of_axis: of the roll axis, through the centre of gravity, below the waterline [m], negative above it.
        keel_breadth: of the bilge keels [m]; 0 without.
        keel_ends: places of their ends, forward of the origin [m].
    """

    sections: tuple[RollSection, ...]
    length: float
    beam: float
    draught: float
    volume: float
    depth_of_axis: float
    keel_breadth: float = 0.0
    keel_ends: tuple[float, float] = (0.0, 0.0)

    @property
    def block(self) -> float:
        """Block coefficient [-]."""
        return self.volume / (self.length * self.beam * self.draught)

    @property
    def midship(self) -> float:
        """Area coefficient of the largest section [-]."""
        return max(self.sections, key=lambda s: s.area).fullness


@dataclass(frozen=True)
class LinearAndQuadratic:
    """linear [N m s], quadratic [N m s^2]: b1 p + b2 |p| p."""

    linear: float
    quadratic: float


@dataclass(frozen=True)
class SectionDamping:
    """Damping at rest by its cause: waves are linear [N m s], eddies quadratic [N m s^2], friction and keels both."""

    friction: LinearAndQuadratic
    waves: float
    eddies: float
    keels: LinearAndQuadratic


def section_damping(ship: RollSections, frequency: float, density: float) -> SectionDamping:
    """Damping at rest at a frequency [rad/s] in water of a density [kg/m^3].

    Raises:
        InputError: a section that is beyond the method.
    """
    eddies = density * eddy_moment(ship)
    friction, keels = (
        LinearAndQuadratic(
            *linear_and_quadratic([of(ship, float(a), frequency, density) for a in AMPLITUDES], frequency)
        )
        for of in (friction_damping, keel_damping)
    )
    return SectionDamping(friction, density * wave_damping(ship, frequency), eddies, keels)


def friction_damping(ship: RollSections, amplitude: float, frequency: float, density: float) -> float:
    """Equivalent linear damping of the hull's friction [N m s] after Kato (ITTC 2.2.3): laminar, and the part that
    turbulence adds, almost nothing for models.
    """
    surface = ship.length * (1.7 * ship.draught + ship.block * ship.beam)
    radius = ((0.887 + 0.145 * ship.block) * surface / ship.length - 2 * ship.depth_of_axis) / np.pi
    reynolds = radius**2 * amplitude**2 * frequency / VISCOSITY
    laminar = 0.787 * density * surface * radius**2 * np.sqrt(frequency * VISCOSITY)
    return float(laminar * (1 + 0.00814 * reynolds**0.386))


def wave_damping(ship: RollSections, frequency: float) -> float:
    """Linear damping of the waves that the sections make about the roll axis, over the density [m^5/s]."""
    motion = np.array([-ship.depth_of_axis, 0.0, 1.0])  # y to z: about a deep axis, to port
    found = 0.0
    for section in ship.sections:
        points = section.points
        if points is None:
            form = form_of(section)
            points = tuple((float(y), float(z)) for y, z in form.points(_PANELS))
        found += section.width * float(motion @ _damping_of(points, frequency) @ motion)
    return found


@lru_cache(maxsize=512)
def _damping_of(points: tuple[tuple[float, float], ...], frequency: float) -> Values:
    """`(3, 3)` of sway, heave and roll, y to z, per length and density."""
    return np.asarray(frequency * section_radiation(np.array(points), frequency).momentum.imag)


def form_of(section: RollSection) -> LewisForm:
    """Its Lewis form.

    Raises:
        InputError: the section has none.
    """
    try:
        return lewis_form(section.beam, section.draught, section.area)
    except InputError as error:
        raise InputError(f"{section.name}: {error}: leave this section out") from None


def eddy_moment(ship: RollSections) -> float:
    """Quadratic damping of the eddies, over the density [m^5]: of the sections' C_R rho/2 d^4 p |p| (equation 6)."""
    return sum(0.5 * s.width * s.draught**4 * eddy_coefficient(s, ship.depth_of_axis) for s in ship.sections)


def eddy_coefficient(section: RollSection, depth_of_axis: float) -> float:
    """Drag coefficient C_R of a section in roll [-] (equations 10, 12 to 15, A-1 to A-10).

    Sections of little fullness come out a few thousandths below 0, as published.

    Raises:
        InputError: the section has no Lewis form, or none below the roll axis.
    """
    d, below, full = section.draught, depth_of_axis / section.draught, section.fullness
    form_of(section)  # the whole section must have a form, not only its part below the axis
    under = section.below(depth_of_axis)
    form = form_of(under)
    distance, angle = _farthest(form)
    velocity = distance + 2 * form.scale * _stretch(form, angle)
    sharp = 1 + 4 * np.exp(-1.65e5 * (1 - full) ** 2)
    mean = 2 * d * (1 - below) * np.sqrt(under.ratio * under.fullness / np.pi)
    gamma = sharp * velocity / mean
    pressure = 0.5 * (0.87 * np.exp(-gamma) - 4 * np.exp(-0.187 * gamma) + 3)  # 14
    turned = np.pi * full
    f1 = 0.5 * (1 + np.tanh(20 * (full - 0.7)))  # 12
    f2 = 0.5 * (1 - np.cos(turned)) - 1.5 * (1 - np.exp(-5 * (1 - full))) * np.sin(turned) ** 2  # 15
    cut = f1 * section.radius / d
    arms = (1 - cut) * (1 - below - cut) + f2 * (section.ratio - cut) ** 2
    return float((distance / d) ** 2 * pressure * arms)  # 10, 13


def _farthest(form: LewisForm) -> tuple[float, float]:
    """Distance of the contour's farthest point from the middle of its waterline [m], its angle [rad] (A-5 to A-7)."""
    a1, a3 = form.first, form.third
    middle = np.clip(a1 * (1 + a3) / (4 * a3), -1, 1) if a3 != 0 else 1.0
    angles = (0.0, 0.5 * float(np.arccos(middle)))
    far = [float(np.hypot(form.out(a), form.down(a))) for a in angles]
    return (far[0], angles[0]) if far[0] >= far[1] else (far[1], angles[1])


def _stretch(form: LewisForm, angle: float) -> float:
    """Speed of the water at the contour in a roll about the middle of its waterline, over twice the
    scale and the rate.

    As potential flow about the form has it, which is what A-2 to A-4 write out in sines and cosines.
    """
    a1, a3 = form.first, form.third
    turn = np.exp(2j * (angle - np.pi / 2))  # over the mapped circle's point, squared
    return float(abs(a1 * (1 + a3) + 2 * a3 * turn) / abs(1 - a1 * turn - 3 * a3 * turn**2))


def keel_damping(ship: RollSections, amplitude: float, frequency: float, density: float) -> float:
    """Equivalent linear damping of bilge keels [N m s]; between sections it is linear."""
    per_length = []
    for section in ship.sections:
        bilge = Bilge(section.ratio, section.draught, section.fullness, section.radius, ship.depth_of_axis)
        of_keel = (bilge, ship.keel_breadth, amplitude, frequency, density)
        per_length.append(keel_force_damping(*of_keel) + keel_pressure_damping(*of_keel))
    x = np.linspace(*ship.keel_ends, 201)
    return float(np.trapezoid(np.interp(x, [s.position for s in ship.sections], per_length), x))


def friction_at_speed(speed: Array, frequency: float, length: float) -> Array:
    """Friction at a speed [m/s] over that at rest (Tamiya and Komura; ITTC 2.2.3)."""
    return 1 + 4.1 / (frequency * length) * speed


def eddies_at_speed(speed: Array, frequency: float, length: float) -> Array:
    """Eddies at a speed [m/s] over those at rest: the flow ahead takes them along (ITTC 2.2.4)."""
    swept = dr.square(speed / (0.04 * frequency * length))
    return 1 / (1 + swept)


def waves_at_speed(speed: Array, frequency: float, draught: float, gravity: float) -> Array:
    """Waves at a speed [m/s] over those at rest, by doublets under the surface (Ikeda 1978; ITTC 2.2.1).

    Fitted for speeds up to w U / g of 1 or so: two bounds, and a hump at 1/4, where waves cannot leave ahead.
    """
    depth = frequency**2 * draught / gravity
    fall = float(np.exp(-2 * depth))
    a1, a2 = 1 + depth**-1.2 * fall, 0.5 + fall / depth
    tau = frequency / gravity * speed
    step = (a2 - 1) * dr.tanh(20 * (tau - 0.3))
    hump = (2 * a1 - a2 - 1) * dr.exp(-150 * dr.square(tau - 0.25))
    return 0.5 * (a2 + 1 + step + hump)
