"""Seakeeping of floating hulls: pressure on the wet hull, and forces of motion through the water, with their memory.

In still water a vehicle's own linear hydrostatics hold. In waves they make place for the pressure of the water, at rest
and in undisturbed waves, on the hull's mesh as it is cut by the actual surface (buoyancy, Froude and Krylov), for added
mass times the water's acceleration relative to the hull (diffraction of waves that are longer than the hull) or, where
a panel method's coefficients have it, for the force of the waves that the hull scatters (`diffraction.py`), and for
Cummins' memory of radiated waves, as a sum of exponentials whose weights are fitted to coefficients of a panel method.
What speed ahead changes is that of strip theory (`forward_speed.py`). Drift is of second order (`drift.py`). Slamming
and water on deck are not part of it.

Sources: W. E. Cummins, Schiffstechnik 9:101 (1962); O. M. Faltinsen, Sea Loads on Ships and Offshore Structures (1990),
Section 3.5; T. Perez and T. I. Fossen, Modeling, Identification and Control 29:1 (2008), doi 10.4173/mic.2008.1.1.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.hydro.algebra import Matrix, Vector, add, matmul, matvec, minus, scaled, transpose
from pelagos.jit import Array
from pelagos.ocean.hull_waves import HullWaves, Waterplane, hull_waves
from pelagos.vehicles.afloat_config import AfloatConfig, RadiationConfig
from pelagos.vehicles.diffraction import Diffraction, compile_diffraction
from pelagos.vehicles.drift import Drift, compile_drift
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.forward_speed import ForwardSpeed
from pelagos.vehicles.hull_at_rest import mesh_stiffness, to_waterline, unbalanced, unbalanced_rest
from pelagos.vehicles.hull_pressure import HullTable, StillWater, hull_pressure, hull_table
from pelagos.vehicles.part import Body, numbers
from pelagos.vehicles.radiation_kernels import Kernel, momentum, radiation_kernels, remember, states
from pelagos.vehicles.shape.floating_mesh import float_mesh
from pelagos.vehicles.shape.pontoon import displaced, pontoon_mesh

Values = NDArray[np.float64]


@dataclass(frozen=True)
class Seakeeping:
    """A hull in waves, compiled.

    Attributes:
        vertices, faces: FRD [m], closed.
        plane: the box about the wet part.
        density: that it floats at the origin in [kg/m^3].
        gravity: [m/s^2].
        rest: what weight and pressure leave unbalanced at rest (6) [N], [N m].
        weight, center_of_gravity: [N], (3) [m].
        added: M_A `(6, 6)`, at infinite frequency where there are kernels.
        stiffness: what pressure and weight restore near rest, about the origin `(6, 6)`: heave, roll and pitch.
        kernels: of the memory.
        drift: of second order; None: none.
        diffraction: of first order; None: added mass times the water's acceleration, and memory of motion relative to
            the water, stand for it.
        ahead: what speed ahead changes; None: coefficients of zero speed.
    """

    vertices: Values
    faces: NDArray[np.int64]
    plane: Waterplane
    density: float
    gravity: float
    rest: Sequence[float]
    weight: float
    center_of_gravity: Sequence[float]
    added: Matrix
    stiffness: NDArray[np.float64]
    kernels: tuple[Kernel, ...]
    drift: Drift | None
    diffraction: Diffraction | None = None
    ahead: ForwardSpeed | None = None

    @property
    def memory(self) -> int:
        """Number of values in the memory."""
        return states(self.kernels) + (0 if self.ahead is None else states(self.ahead.kernels))

    def table(self) -> HullTable:
        """The mesh on the device."""
        drift, diffraction = (
            jit.Float64(0.0) if of is None else of.rows.on_device() for of in (self.drift, self.diffraction)
        )
        return hull_table(self.vertices, self.faces, drift=drift, diffraction=diffraction)

    def waves(
        self, ocean: Any, position: Vector, rotation: Matrix, t: Array, *, speed: Array | None = None
    ) -> HullWaves:
        """The waves at the hull; position NED, rotation FRD -> NED; speed: see `hull_waves`."""
        north, west = position[0], -position[1]
        return hull_waves(self._sea(ocean, position), north, west, _heading(rotation), t, self.plane, speed=speed)

    @staticmethod
    def _sea(ocean: Any, position: Vector) -> Any:
        """The waves of the copy that each hull is in."""
        return ocean.sea(dr.width(position[0]))

    def to_body(self, rotation: Matrix, level: Vector) -> list[Array]:
        """A vector (6) along the heading, in body axes."""
        turn = transpose(upright(rotation))
        return [*matvec(turn, level[:3]), *matvec(turn, level[3:])]

    def load(
        self,
        ocean: Any,
        waves: HullWaves,
        position: Vector,
        rotation: Matrix,
        water: Vector,
        t: Array,
        table: HullTable,
        *,
        speed: Array | None = None,
    ) -> list[Array]:
        """Pressure, weight, drift, and added mass times the acceleration of the `water` (6, body axes) (6).

        `speed`: ahead through the water [m/s], for diffraction that depends on it.
        """
        place = jit.Array3f64(position[0], -position[1], dr.minimum(-position[2], 0.0))
        weight = ocean.density(place, t) * self.gravity
        depth = position[2] if ocean.tide is None else position[2] + ocean.tide.level(t)
        turn = upright(rotation)
        force, moment = hull_pressure(waves, table, turn, depth)
        if self.drift is not None:
            north, west = position[0], -position[1]
            x, y, n = self.drift.push(self._sea(ocean, position), table.drift, north, west, _heading(rotation), t)
            per, back = 1 / self.gravity, transpose(turn)
            force = add(force, matvec(back, [per * x, per * y, 0.0]))
            moment = add(moment, matvec(back, [0.0, 0.0, per * n]))
        wet = self._with_weight(weight, force, moment, rotation)
        if self.diffraction is None:
            return add(wet, matvec(self.added, water))
        place = position[0], -position[1]
        scattered = self.diffraction.push(
            self._sea(ocean, position), table.diffraction, place, _heading(rotation), t, speed=speed
        )
        return add(wet, scaled(weight / self.gravity, self.to_body(rotation, scattered)))

    def still_load(self, depth: Array, rotation: Matrix, table: HullTable, active: Array) -> list[Array]:
        """Pressure and weight (6) in `active` lanes, in still water of the density that the hull is made for.

        `depth`: of the origin [m]; rotation FRD -> NED.
        """
        force, moment = hull_pressure(StillWater(), table, upright(rotation), depth, active)
        return self._with_weight(self.density * self.gravity, force, moment, rotation)

    def _with_weight(self, weight: Array, force: Vector, moment: Vector, rotation: Matrix) -> list[Array]:
        wet = [weight * f for f in [*force, *moment]]
        down = [self.weight * r for r in rotation[2]]
        heavy = [*down, *_cross(self.center_of_gravity, down)]
        return add(wet, heavy, minus(self.rest))

    def remember(self, memory: Sequence[Array], velocity: Vector, h: Array) -> tuple[list[Array], list[Array]]:
        """The memory after h [s] at a velocity (6) relative to the water, and the wrench (6) in that step's middle."""
        split = states(self.kernels)
        new, wrench = remember(self.kernels, memory[:split], velocity, h)
        if self.ahead is None:
            return new, wrench
        return [*new, *self.ahead.remember(memory[split:], velocity, h)], wrench

    def load_at_speed(self, before: Sequence[Array], after: Sequence[Array], flow: Flow) -> list[Array]:
        """The part (6) of the radiated waves' load that the hull's speed makes; memory before and after the step."""
        if self.ahead is None or flow.seaway is None:
            return [0.0] * 6
        split = states(self.kernels)
        radiated = momentum(self.kernels, before[:split], after[:split])
        return self.ahead.load(flow, radiated, before[split:], after[split:])


def _heading(rotation: Matrix) -> tuple[Array, Array]:
    """Cosine and sine of the compass heading."""
    size = dr.sqrt(rotation[0][0] * rotation[0][0] + rotation[1][0] * rotation[1][0])
    return rotation[0][0] / size, rotation[1][0] / size


def speed_along(rotation: Matrix, velocity: Vector) -> Array:
    """Part along the heading of a velocity (3) NED; rotation FRD -> NED."""
    cos, sin = _heading(rotation)
    return cos * velocity[0] + sin * velocity[1]


def upright(rotation: Matrix) -> list[list[Array]]:
    """Body axes to axes along the heading, level: `(3, 3)`, from FRD -> NED."""
    cos, sin = _heading(rotation)
    return matmul([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]], rotation)


def compile_seakeeping(config: AfloatConfig, body: Body) -> Seakeeping:
    """The hull of a body that floats, at the draught at which it carries the weight.

    Raises:
        ValueError: coefficients that are missing, or a freeboard that the draught leaves nothing of.
    """
    volume = body.weight / body.gravity / body.density
    if config.mesh is not None:
        hull = float_mesh(config.mesh, volume)
        length, half = (float(v) for v in np.abs(hull.vertices[:, :2]).max(axis=0))
        plane = Waterplane(2 * length, half, float(hull.vertices[:, 2].max()), False)
        return _compiled(config, body, hull.vertices, hull.faces, plane, unbalanced_rest(body, volume, hull.center))
    draught = volume / sum(h.volume_per_draught for h in config.hulls)
    draught *= volume / sum(displaced(*to_waterline(h, draught)) for h in config.hulls)  # strips hold a little less
    meshes = [pontoon_mesh(h, draught, along=8) for h in config.hulls]
    vertices = np.concatenate([v for v, _ in meshes])
    starts = np.cumsum([0, *(len(v) for v, _ in meshes[:-1])])
    faces = np.concatenate([f + s for (_, f), s in zip(meshes, starts, strict=True)])
    sides = max(abs(h.position_y_m) for h in config.hulls)
    outer = max(abs(h.position_y_m) + h.beam_m / 2 for h in config.hulls)
    reach = max(abs(h.position_x_m) + h.length_m / 2 for h in config.hulls)
    plane = Waterplane(2 * reach, sides or outer, draught, sides > 0)
    return _compiled(config, body, vertices, faces, plane, unbalanced(config, draught, body))


def _compiled(
    config: AfloatConfig, body: Body, vertices: Values, faces: NDArray[np.int64], plane: Waterplane, rest: list[float]
) -> Seakeeping:
    coefficients = config.coefficients
    added = body.added if coefficients is None else body.density * np.array(coefficients.added_mass_infinite)
    kernels = () if coefficients is None else radiation_kernels(coefficients, body.density)
    return Seakeeping(
        vertices=vertices,
        faces=faces,
        plane=plane,
        density=body.density,
        gravity=body.gravity,
        rest=rest,
        weight=body.weight,
        center_of_gravity=[float(x) for x in body.center_of_gravity],
        added=numbers(added),
        stiffness=mesh_stiffness(vertices, faces, body),
        kernels=kernels,
        drift=None if config.drift_coefficients is None else compile_drift(config.drift_coefficients),
        diffraction=_diffraction(coefficients),
    )


def _diffraction(coefficients: RadiationConfig | None) -> Diffraction | None:
    if coefficients is None or coefficients.diffraction is None:
        return None
    return compile_diffraction(coefficients.diffraction)


def _cross(a: Sequence[Array], b: Sequence[Array]) -> list[Array]:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
