"""Seakeeping of floating hulls: pressure on the wet hull, and forces of motion through the water, with their memory.

In still water a vehicle's own linear hydrostatics hold. In waves they make place for the pressure of the water, at rest
and in undisturbed waves, on the hull's mesh as it is cut by the actual surface (buoyancy, Froude and Krylov), for added
mass times the water's acceleration relative to the hull (diffraction of waves that are longer than the hull), and for
Cummins' memory of radiated waves, as a sum of exponentials whose weights are fitted to coefficients of a panel method.
Drift is of second order (`drift.py`). Slamming and water on deck are not part of it.

Sources: W. E. Cummins, Schiffstechnik 9:101 (1962); O. M. Faltinsen, Sea Loads on Ships and Offshore Structures (1990),
Section 3.5; T. Perez and T. I. Fossen, Modeling, Identification and Control 29:1 (2008), doi 10.4173/mic.2008.1.1.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any, Final, Literal, Self

import drjit as dr
import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from pelagos import jit
from pelagos.config.path import MeshPath
from pelagos.errors import did_you_mean
from pelagos.hydro.algebra import Matrix, Vector, add, matmul, matvec, minus, transpose
from pelagos.hydro.radiation import fit_memory, retardation
from pelagos.jit import Array
from pelagos.ocean.hull_waves import HullWaves, Waterplane, hull_waves
from pelagos.vehicles.drift import Drift, DriftConfig, compile_drift
from pelagos.vehicles.hull_pressure import HullTable, StillWater, hull_pressure, hull_table
from pelagos.vehicles.part import Body, PartConfig, Positive, numbers
from pelagos.vehicles.shape.floating_mesh import float_mesh, wet_part
from pelagos.vehicles.shape.pontoon import PontoonConfig, displaced, pontoon_mesh

Values = NDArray[np.float64]
_ORDER: Final = 4  # states a kernel
_CATALOGUE: Final = "pelagos.vehicles.catalogue"
_BEM: Final = ".bem.json"


class RadiationConfig(PartConfig):
    """Coefficients of a panel method about the origin at the waterline, FRD, deep water, over the water's density."""

    source: str
    """Program and version."""
    omega_radps: tuple[Positive, ...] = Field(min_length=4)
    """Frequencies, increasing [rad/s]."""
    added_mass_infinite: tuple[tuple[float, ...], ...]
    """`(6, 6)` at infinite frequency."""
    added_mass: tuple[tuple[tuple[float, ...], ...], ...] = ()
    """`(frequencies, 6, 6)`; not used in the time domain."""
    damping: tuple[tuple[tuple[float, ...], ...], ...]
    """`(frequencies, 6, 6)`."""
    drift: DriftConfig | None = None
    """Mean forces of second order; see `drift` of `afloat`."""

    @model_validator(mode="after")
    def _shapes(self) -> Self:
        n = len(self.omega_radps)
        if np.shape(self.added_mass_infinite) != (6, 6) or np.shape(self.damping) != (n, 6, 6):
            raise ValueError(f"added_mass_infinite must be 6 x 6 and damping {n} x 6 x 6, one matrix a frequency")
        if (np.diff(self.omega_radps) <= 0).any():
            raise ValueError("omega_radps must increase")
        return self


class AfloatConfig(PartConfig):
    """The hull in the water."""

    hulls: tuple[PontoonConfig, ...] = ()
    """All hulls; they carry the vehicle's weight at one draught, and lie level where the origin is at the surface."""
    mesh: MeshPath | None = None
    """Instead of `hulls`, a file with a closed mesh of at most 5000 triangles, forward-left-up [m]; it is moved up or
    down until its wet part carries the weight with the origin at the surface."""
    radiation: str | RadiationConfig | None = None
    """Coefficients, or the catalogue's file of them; without, added mass and damping of the vehicle stand for all."""
    drift: str | DriftConfig | None = None
    """Mean and slowly varying forces of second order: coefficients, or the catalogue's file that has them; without,
    none."""
    restoring: Literal["term", "hull"] = "term"
    """What holds near rest where the hydrostatic term and the hull's pressure differ: the term (a measured or published
    stiffness) up to heaves of half the draught and tilts of 15 degrees, or the hull throughout."""

    @model_validator(mode="after")
    def _one_form(self) -> Self:
        if (self.mesh is None) == (not self.hulls):
            raise ValueError("give either hulls or mesh")
        return self

    @model_validator(mode="after")
    def _known(self) -> Self:
        known = sorted(p.name.removesuffix(_BEM) for p in files(_CATALOGUE).iterdir() if p.name.endswith(_BEM))
        for key in ("radiation", "drift"):
            name = getattr(self, key)
            if isinstance(name, str) and name not in known:
                raise ValueError(f"{key} {name!r} is none of {', '.join(known)}{did_you_mean(name, known)}")
        if isinstance(self.drift, str) and _from_catalogue(self.drift).drift is None:
            having = [name for name in known if _from_catalogue(name).drift is not None]
            raise ValueError(f"{self.drift!r} has no drift coefficients that can be trusted; {', '.join(having)} have")
        return self

    @property
    def coefficients(self) -> RadiationConfig | None:
        """Read from the catalogue where a name is given."""
        return _from_catalogue(self.radiation) if isinstance(self.radiation, str) else self.radiation

    @property
    def drift_coefficients(self) -> DriftConfig | None:
        """Read from the catalogue where a name is given."""
        return _from_catalogue(self.drift).drift if isinstance(self.drift, str) else self.drift


@cache
def _from_catalogue(name: str) -> RadiationConfig:
    path = files(_CATALOGUE) / f"{name}{_BEM}"
    return RadiationConfig.model_validate(json.loads(path.read_text(encoding="utf-8")))


@dataclass(frozen=True)
class Kernel:
    """Radiation force in direction `row` after velocities in `column`: the real part of sum weight e^{pole t}.

    Attributes:
        row, column: 0 to 5.
        poles: [1/s], of each pair one; real ones first have no imaginary part.
        weights: complex [N/m] and the like.
    """

    row: int
    column: int
    poles: tuple[complex, ...]
    weights: tuple[complex, ...]


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

    @property
    def memory(self) -> int:
        """How many numbers the memory has."""
        return 2 * sum(len(k.poles) for k in self.kernels)

    def table(self) -> HullTable:
        """The mesh on the device."""
        drift = jit.Float64(0.0) if self.drift is None else self.drift.table()
        return hull_table(self.vertices, self.faces, drift)

    def waves(self, ocean: Any, position: Vector, rotation: Matrix, t: Array) -> HullWaves:
        """The waves at the hull; position NED, rotation FRD -> NED."""
        return hull_waves(ocean.waves, position[0], -position[1], _heading(rotation), t, self.plane)

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
    ) -> list[Array]:
        """Pressure, weight, drift, and added mass times the acceleration of the `water` (6, body axes) (6)."""
        place = jit.Array3f64(position[0], -position[1], dr.minimum(-position[2], 0.0))
        weight = ocean.density(place, t) * self.gravity
        depth = position[2] if ocean.tide is None else position[2] + ocean.tide.level(t)
        turn = upright(rotation)
        force, moment = hull_pressure(waves, table, turn, depth)
        if self.drift is not None:
            north, west = position[0], -position[1]
            x, y, n = self.drift.push(ocean.waves, table.drift, north, west, _heading(rotation), t)
            per, back = 1 / self.gravity, transpose(turn)
            force = add(force, matvec(back, [per * x, per * y, 0.0]))
            moment = add(moment, matvec(back, [0.0, 0.0, per * n]))
        return add(self._with_weight(weight, force, moment, rotation), matvec(self.added, water))

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
        new: list[Array] = []
        wrench: list[Array] = [0.0] * 6
        at = 0
        for kernel in self.kernels:
            v = velocity[kernel.column]
            for pole, weight in zip(kernel.poles, kernel.weights, strict=True):
                re, im = memory[at], memory[at + 1]
                at += 2
                size = dr.exp(pole.real * h)
                s, c = dr.sincos(pole.imag * h)
                gr, gi = size * c, size * s
                inverse = 1 / pole  # (e^{p h} - 1) / p, exact for a velocity that is constant in the step
                ur, ui = (gr - 1) * inverse.real - gi * inverse.imag, (gr - 1) * inverse.imag + gi * inverse.real
                nr, ni = gr * re - gi * im + ur * v, gr * im + gi * re + ui * v
                new += [nr, ni]
                push = 0.5 * (weight.real * (re + nr) - weight.imag * (im + ni))
                wrench[kernel.row] = wrench[kernel.row] - push
        return new, wrench


def _heading(rotation: Matrix) -> tuple[Array, Array]:
    """Cosine and sine of the compass heading."""
    size = dr.sqrt(rotation[0][0] * rotation[0][0] + rotation[1][0] * rotation[1][0])
    return rotation[0][0] / size, rotation[1][0] / size


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
        return _compiled(config, body, hull.vertices, hull.faces, plane, _rest(body, volume, hull.center))
    draught = volume / sum(h.volume_per_draught for h in config.hulls)
    draught *= volume / sum(displaced(*_to_waterline(h, draught)) for h in config.hulls)  # strips hold a little less
    meshes = [pontoon_mesh(h, draught, along=8) for h in config.hulls]
    vertices = np.concatenate([v for v, _ in meshes])
    starts = np.cumsum([0, *(len(v) for v, _ in meshes[:-1])])
    faces = np.concatenate([f + s for (_, f), s in zip(meshes, starts, strict=True)])
    sides = max(abs(h.position_y_m) for h in config.hulls)
    outer = max(abs(h.position_y_m) + h.beam_m / 2 for h in config.hulls)
    reach = max(abs(h.position_x_m) + h.length_m / 2 for h in config.hulls)
    plane = Waterplane(2 * reach, sides or outer, draught, sides > 0)
    return _compiled(config, body, vertices, faces, plane, _unbalanced(config, draught, body))


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
    )


def mesh_stiffness(vertices: Values, faces: NDArray[np.int64], body: Body) -> Values:
    """G `(6, 6)` about the origin of a mesh, FRD, that floats there: -d load / d (heave, roll, pitch), still water."""
    flip, step = np.array([1.0, -1.0, -1.0]), 1e-3
    stiffness = np.zeros((6, 6))
    half = float(np.abs(vertices[:, :2]).max())

    def load(heave: float, roll: float, pitch: float) -> Values:
        (sr, cr), (sp, cp) = ((math.sin(a), math.cos(a)) for a in (roll, pitch))
        turn = np.array([[cp, sp * sr, sp * cr], [0.0, cr, -sr], [-sp, cp * sr, cp * cr]])  # body to level
        volume, center = wet_part((vertices @ turn.T + [0.0, 0.0, heave]) * flip, faces, 0.0)
        push = np.array([0.0, 0.0, -body.density * body.gravity * volume])
        down = np.array([0.0, 0.0, body.weight])
        arm = center * flip - [0.0, 0.0, heave]
        moment = np.cross(arm, push) + np.cross(turn @ body.center_of_gravity, down)
        return np.concatenate([turn.T @ (push + down), turn.T @ moment])

    for axis, move in ((2, np.array([1.0, 0, 0])), (3, np.array([0, 1.0, 0])), (4, np.array([0, 0, 1.0]))):
        size = step * (body.weight / body.gravity / body.density) ** (1 / 3) / (1.0 if axis == 2 else half)
        stiffness[:, axis] = (load(*(-size * move)) - load(*(size * move))) / (2 * size)
    stiffness[np.abs(stiffness) < 1e-7 * np.abs(stiffness).max()] = 0.0
    return stiffness


def _to_waterline(hull: PontoonConfig, draught: float) -> tuple[Values, NDArray[np.int64]]:
    return pontoon_mesh(hull, draught, along=8, deck=False)


def _unbalanced(config: AfloatConfig, draught: float, body: Body) -> list[float]:
    """Wrench (6) of weight and still water on the hull as it lies."""
    volume, first = 0.0, np.zeros(3)
    for hull in config.hulls:
        vertices, faces = _to_waterline(hull, draught)
        p, q, r = (vertices[faces[:, k]] for k in range(3))
        lots = np.einsum("fi,fi->f", p, np.cross(q, r)) / 6
        volume += float(lots.sum())
        first += np.einsum("f,fi->i", lots, (p + q + r) / 4)
    return _rest(body, volume, first / volume)


def _rest(body: Body, volume: float, center: Values) -> list[float]:
    push = np.array([0.0, 0.0, -body.density * body.gravity * volume])
    down = np.array([0.0, 0.0, body.weight])
    moment = np.cross(center, push) + np.cross(body.center_of_gravity, down)
    return [float(x) for x in [*(push + down), *moment]]


def radiation_kernels(coefficients: RadiationConfig, density: float) -> tuple[Kernel, ...]:
    """Every kernel that matters, as a sum of exponentials."""
    omega, damping = np.array(coefficients.omega_radps), density * np.array(coefficients.damping)
    omega, damping = np.concatenate([[0.0], omega]), np.concatenate([np.zeros((1, 6, 6)), damping])
    tail = omega[-1] * np.geomspace(1.05, 4, 40)  # beyond the last frequency it falls as a wave maker's, omega^-3
    damping = np.concatenate([damping, damping[-1] * ((omega[-1] / tail) ** 3)[:, None, None]])
    omega = np.concatenate([omega, tail])
    largest = np.abs(damping).max(axis=0)
    found = []
    for row in range(6):
        for column in range(6):
            scale = math.sqrt(largest[row, row] * largest[column, column])
            if scale > 0 and largest[row, column] > 0.01 * scale:
                found.append(_kernel(row, column, omega, damping[:, row, column]))
    return tuple(found)


def _kernel(row: int, column: int, omega: Values, damping: Values) -> Kernel:
    peak = omega[int(np.argmax(np.abs(damping)))]
    step = 0.08 / peak
    t = step * np.arange(800)
    kernel = retardation(t, omega, damping)
    poles = np.log(np.linalg.eigvals(fit_memory(kernel, step, _ORDER).phi).astype(complex)) / step
    poles = np.minimum(poles.real, -0.01 * peak) + 1j * poles.imag
    poles = poles[poles.imag >= -1e-12]
    return Kernel(row, column, tuple(map(complex, poles)), tuple(map(complex, steady_weights(t, kernel, poles))))


def steady_weights(t: Values, kernel: Values, poles: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Weights of exponentials for a kernel at times t [s], by least squares under one condition: no force in the end.

    A body that moves steadily radiates nothing, so the kernel's integral is zero (T. Perez and T. I. Fossen 2008,
    Table 1); one that is not acts as a damping, and where it is negative as an engine.
    """
    waves = np.exp(poles * t[:, None])
    basis = np.concatenate([waves.real, -waves.imag], axis=1)
    end = np.concatenate([(-1 / poles).real, (1 / poles).imag])  # of the real part of weight times -1 / pole
    real = np.abs(poles.imag) < 1e-12
    used = np.concatenate([np.ones(len(poles), bool), ~real])
    basis, end = basis[:, used], end[used]
    normal = np.block([[basis.T @ basis, end[:, None]], [end[None], np.zeros((1, 1))]])
    found = np.linalg.lstsq(normal, np.append(basis.T @ kernel, 0.0), rcond=None)[0][:-1]
    parts = np.zeros(2 * len(poles))
    parts[used] = found
    return np.asarray(parts[: len(poles)] + 1j * parts[len(poles) :])


def _cross(a: Sequence[Array], b: Sequence[Array]) -> list[Array]:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
