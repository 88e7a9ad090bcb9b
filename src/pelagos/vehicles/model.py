"""The equation of motion of a vehicle: a sum of terms, and one mass matrix.

    M (nu_dot - current_rate) = sum of wrenches - C(nu_c) nu_c,   M = M_RB + M_A

Source: F21 Chapters 6 and 8. The numbers in a model are Python numbers, part of the compiled program; any of them may
be replaced by a Dr.Jit array (`dataclasses.replace`), for gradients or for a fleet in which every copy has its own.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final, Protocol

import drjit as dr
import numpy as np

from pelagos import jit
from pelagos.hydro.algebra import Matrix, Vector, add, matvec, minus, mul, scaled, solve_blocks, solve_symmetric
from pelagos.hydro.coriolis import coriolis_force, coriolis_force_angular, coriolis_matrix, coriolis_matrix_angular
from pelagos.hydro.rigid_body import transport
from pelagos.jit import Array
from pelagos.math.either import either
from pelagos.vehicles.actuators.actuator import Actuator, Follower
from pelagos.vehicles.actuators.t200 import T200, Battery
from pelagos.vehicles.cargo import Carrier, carriers_of, carrying, growing, growth_of
from pelagos.vehicles.flow import Flow, Supply
from pelagos.vehicles.inertia import CoriolisConfig
from pelagos.vehicles.interaction import Interaction
from pelagos.vehicles.nearby import GroundMass, Image, feels_depth, feels_planes, has_image
from pelagos.vehicles.part import Body, numbers
from pelagos.vehicles.seakeeping import Seakeeping
from pelagos.vehicles.tables import Tables
from pelagos.vehicles.wetness import Keeps, Place, Wetness, Wetting, shares_of


def _left(load: Vector, share: Array) -> Vector:
    return load if isinstance(share, float) else [mul(share, x) for x in load]


EVERY: Final = tuple((row, column) for row in range(6) for column in range(6))
"""All entries of a matrix `(6, 6)`."""
_NEUTRAL: Final = 1e-12  # of the mass: rounding


class Term(Protocol):
    """A wrench that follows from the flow alone."""

    def wrench(self, flow: Flow) -> Vector:
        """Force and moment on the body about its origin (6), FRD [N], [N m]."""
        ...


@dataclass(frozen=True)
class Inertia:
    """Mass and added mass.

    Attributes:
        rigid, added: M_RB, M_A `(6, 6)` about the origin.
        inverse: of M_RB + M_A; None: solved for at each evaluation (for entries that are arrays).
        without: entries (row, column), from 0, left out of the added mass's Coriolis matrix.
        angular: (mass, inertia `(3, 3)`, H(r_g)) where the rigid body's part is formed without linear velocity.
        none: no Coriolis forces; the terms contain them.
        excess: M_RB less that of the water displaced `(6, 6)`: what accelerating water does not push; None: nothing.
        displaced: of the water displaced `(6, 6)`; None where that is not what accelerating water pushes.
        symmetric: whether M_A is, as it is not where it was measured entry by entry.
    """

    rigid: Matrix
    added: Matrix
    inverse: Matrix | None
    without: tuple[tuple[int, int], ...] = ()
    angular: tuple[Array, Matrix, Matrix] | None = None
    none: bool = False
    excess: Matrix | None = None
    displaced: Matrix | None = None
    symmetric: bool = True

    @property
    def whole(self) -> Matrix:
        """M = M_RB + M_A `(6, 6)`."""
        return [add(a, b) for a, b in zip(self.rigid, self.added, strict=True)]

    def coriolis(self, flow: Flow) -> Vector:
        """-(C_RB + C_A) nu_c (6)."""
        if self.none:
            return [0.0] * 6
        if flow.midway is not None:
            return minus(matvec(self.coriolis_matrix(flow), flow.nu_c))
        if not self.without and self.angular is None:
            return minus(coriolis_force(self.whole, flow.nu_c))
        if self.angular is None:
            rigid = coriolis_force(self.rigid, flow.nu_c)
        else:
            rigid = coriolis_force_angular(*self.angular, flow.nu_c)
        return minus(add(rigid, coriolis_force(self.added, flow.nu_c, self.without)))

    def coriolis_matrix(self, flow: Flow) -> Matrix:
        """C_RB + C_A `(6, 6)`, of the velocity now or in the middle of the step."""
        nu_c = flow.nu_c if flow.midway is None else flow.midway
        if not self.without and self.angular is None:
            return coriolis_matrix(self.whole, nu_c)
        if self.angular is None:
            rigid = coriolis_matrix(self.rigid, nu_c)
        else:
            rigid = coriolis_matrix_angular(*self.angular, nu_c)
        added = coriolis_matrix(self.added, nu_c, self.without)
        return [add(a, b) for a, b in zip(rigid, added, strict=True)]

    def accelerate(self, wrench: Vector) -> Vector:
        """M^-1 wrench (6)."""
        if self.inverse is not None:
            return matvec(self.inverse, wrench)
        return solve_symmetric(self.whole, wrench) if self.symmetric else solve_blocks(self.whole, wrench)

    def accelerate_partly(self, wrench: Vector, flow: Flow, wet: Wetness, h: Array | None) -> list[Array]:
        """Acceleration (6) of a body that is partly out of the water, `wrench` as of one that is wet everywhere.

        The added mass is that of the wet part; where it grows, its new part takes its momentum from the body, in one
        step of h [s] exactly: (M + s1 M_A) (nu + h a) = (M + s0 M_A) nu without other forces (`hydro.immersion`).
        """
        entering = dr.maximum(wet.rate, 0.0)
        share = wet.share if h is None else dr.minimum(wet.share + h * entering, 1.0)
        gain = entering if h is None else (share - wet.share) / h
        dry = 1 - wet.share
        load = add(wrench, scaled(-gain, matvec(self.added, flow.nu_r)))
        if not self.none:
            load = add(load, scaled(dry, coriolis_force(self.added, flow.nu_c, self.without)))
        if self.displaced is not None and flow.water_acceleration is not None:
            load = add(load, scaled(-dry, matvec(self.displaced, flow.water_acceleration)))
        mass = [add(a, scaled(share, b)) for a, b in zip(self.rigid, self.added, strict=True)]
        return solve_blocks(mass, load)

    def accelerate_over(self, wrench: Vector, flow: Flow, h: Array) -> Vector:
        """(M + h/2 C)^-1 wrench (6): the mean acceleration in a step of h [s] in which Coriolis forces do no work.

        `wrench` has them on the velocity at the step's beginning; they are to act on the mean of those before and after
        it, M a = f - C (nu_r + h/2 a), and C is skew: energy stays. C is that of the step's middle (`Flow.midway`),
        which keeps the angular momentum too, to second order. Linearly implicit midpoint rule: E. Hairer, C. Lubich,
        G. Wanner, "Geometric Numerical Integration", 2nd ed., Springer 2006, Section IV.2.
        """
        if self.none:
            return self.accelerate(wrench)
        half = [[mul(0.5 * h, c) for c in row] for row in self.coriolis_matrix(flow)]
        return solve_blocks([add(a, b) for a, b in zip(self.whole, half, strict=True)], wrench)


@dataclass(frozen=True)
class Model:
    """Everything that accelerates a vehicle.

    Attributes:
        inertia: mass and added mass.
        terms: by name.
        actuators: by name; each has one state and one command. Behind all states stands what some keep beside theirs.
        battery: what feeds T200 thrusters.
        sea: the hull in waves; None where nothing floats, or only follows the surface.
        trim: what the hydrostatic terms restore beyond the hull's pressure near rest; None: nothing.
        wetting: how wet the hull is; None: everywhere.
        in_air: whether the terms are those of a body in air.
        sea_inertia: mass and added mass in waves.
        still: names of terms that pressure stands for in waves.
        calm_damping: names of terms that radiation stands for in waves.
        interaction: thrusters in each other's jets; None: none.
        ground: what the ground under a ship does to its added mass; None: nothing beside what terms and actuators do.
    """

    inertia: Inertia
    terms: Mapping[str, Term]
    actuators: Mapping[str, Actuator] = field(default_factory=dict)
    battery: Battery | None = None
    sea: Seakeeping | None = None
    sea_inertia: Inertia | None = None
    still: frozenset[str] = frozenset()
    calm_damping: frozenset[str] = frozenset()
    trim: Term | None = None
    wetting: Wetting | None = None
    in_air: bool = False
    interaction: Interaction | None = None
    ground: GroundMass | None = None

    @property
    def on_host(self) -> bool:
        """Whether a term computes in NumPy, so that no step can be recorded."""
        return any(getattr(term, "on_host", False) for term in self.terms.values())

    def fed(self, flow: Flow, actuators: Sequence[Array], tables: Tables | None) -> Flow:
        """`flow` with the supply of electric thrusters at these states."""
        if self.battery is None:
            return flow
        assert tables is not None
        assert tables.thrusters is not None
        throttles = [s for a, s in zip(self.actuators.values(), actuators, strict=True) if isinstance(a, T200)]
        return replace(flow, supply=Supply(self.battery.voltage(throttles, tables.thrusters), tables.thrusters))

    def acted(self, flow: Flow, actuators: Sequence[Array]) -> Flow:
        """`flow` with the limited states of actuators."""
        return replace(flow, actuators=dict(zip(self.actuators, actuators, strict=True)))

    def wrenches(self, flow: Flow, actuators: Sequence[Array], tables: Tables | None = None) -> dict[str, Vector]:
        """Every force and moment by the name of its origin, each (6); `actuators`: one limited state each."""
        flow = self.acted(self.fed(flow, actuators, tables), actuators)
        inertia = self.inertia_in(flow)
        found: dict[str, Vector] = {"coriolis": inertia.coriolis(flow)}
        if inertia.without or inertia.none:
            found.update(self._coriolis_of_walls(inertia, flow))
        if flow.seaway is not None:
            found["sea"] = flow.seaway.load
            if self.trim is not None:
                found["trim"] = [mul(1 - flow.far, x) for x in self.trim.wrench(flow)]
        elif flow.water_acceleration is not None and inertia.excess is not None:
            found["excess_mass"] = minus(matvec(inertia.excess, flow.water_acceleration))
        if self.ground is not None and self.ground.momentum:
            found["shoaling"] = _left(self.ground.shoaling(flow), Place("hull").share(flow))
        for name, term in self.terms.items():
            if flow.seaway is None or name not in self.still | self.calm_damping:
                found[name] = self.left(term, term.wrench(flow), flow)
                if name in self.still and flow.calm is not None:
                    found[name] = [
                        dr.select(flow.far > 0, a + flow.far * (b - a), a)
                        for a, b in zip(found[name], flow.calm, strict=True)
                    ]
        shares = shares_of([actuator.site for actuator in self.actuators.values()], flow)
        washes = {} if self.interaction is None else self.interaction.wash(self.actuators, actuators, shares, flow)
        for (name, actuator), state, share in zip(self.actuators.items(), actuators, shares, strict=True):
            here = replace(flow, wash=washes[name]) if name in washes else flow
            found[name] = _left(actuator.wrench(state, here), share)
        return found

    def _coriolis_of_walls(self, inertia: Inertia, flow: Flow) -> dict[str, Vector]:
        """Coriolis forces by walls that a published model of the hull alone leaves out (6), by name."""
        found: dict[str, Vector] = {}
        for name, term in self.terms.items():
            if has_image(term) and getattr(term, "whole_coriolis", False):
                mass = term.image_mass(flow)
                there = [0.0] * 6 if inertia.none else coriolis_force(mass, flow.nu_c, inertia.without)
                found[f"{name} coriolis"] = add(there, minus(coriolis_force(mass, flow.nu_c)))
        return found

    def left(self, term: Term, load: Vector, flow: Flow) -> Vector:
        """Remainder of a term's load (6) where the hull is partly out of the water."""
        keeps: Keeps = getattr(term, "keeps", "dry" if self.in_air else "hull")
        return _left(load, Place(keeps).share(flow))

    def nu_dot(
        self,
        flow: Flow,
        actuators: Sequence[Array],
        outside: Vector = (0.0,) * 6,
        tables: Tables | None = None,
        h: Array | None = None,
    ) -> Vector:
        """Rate of change of nu (6) [m/s^2], [rad/s^2].

        `outside`: a further wrench (6), such as contact; `h`: the mean over a step, see `Inertia.accelerate_over`.
        """
        wrench = add(outside, *self.wrenches(flow, actuators, tables).values())
        inertia = self.inertia_in(self.acted(flow, actuators) if self.carriers else flow)
        if flow.growth is not None:
            wrench = add(wrench, minus(matvec(flow.growth, flow.nu_r)))
            inertia = inertia if flow.step is None else growing(inertia, flow.growth, flow.step)
        if flow.wet is None or self.in_air:
            relative = inertia.accelerate(wrench) if h is None else inertia.accelerate_over(wrench, flow, h)
        else:
            relative = self._where_wet(inertia, wrench, flow, h)
        return add(flow.current_rate, relative)

    def _where_wet(self, inertia: Inertia, wrench: Vector, flow: Flow, h: Array | None) -> list[Array]:
        """Acceleration (6), with the whole added mass where the hull is wet and less where it is not."""
        wet = flow.wet
        assert wet is not None
        step, f64 = flow.step, jit.Float64

        def whole(load: list[Array], nu_r: list[Array], nu: list[Array], *_: Any) -> list[Array]:
            if h is None:
                return [f64(a) for a in inertia.accelerate(load)]
            return [f64(a) for a in inertia.accelerate_over(load, replace(flow, nu_r=nu_r, nu=nu), h)]

        def partly(
            load: list[Array], nu_r: list[Array], nu: list[Array], water: list[Array], share: Array, rate: Array
        ) -> list[Array]:
            here = replace(flow, nu_r=nu_r, nu=nu, water_acceleration=water if flow.water_acceleration else None)
            return [f64(a) for a in inertia.accelerate_partly(load, here, Wetness(share, rate), step)]

        given = [[f64(x) for x in part] for part in (wrench, flow.nu_r, flow.nu, flow.water_acceleration or [0.0] * 6)]
        share, rate = f64(wet.share), f64(wet.rate)
        return either((*given, share, rate), share < 1, partly, whole)

    def inertia_in(self, flow: Flow) -> Inertia:
        """Mass and added mass, in waves perhaps a panel method's, with what is carried and what is near."""
        inertia = self.inertia if flow.seaway is None or self.sea_inertia is None else self.sea_inertia
        for term in self.images:
            added = [add(row, more) for row, more in zip(inertia.added, term.image_mass(flow), strict=True)]
            inertia = replace(inertia, added=added, inverse=None)
        if not self.carriers or not flow.actuators:
            return inertia
        return carrying(inertia, [carrier.cargo(flow.actuators[name], flow) for name, carrier in self.carriers.items()])

    @property
    def images(self) -> list[Image]:
        """Parts that change the added mass near a plane."""
        parts = [*self.terms.values(), *self.actuators.values()]
        return [part for part in parts if has_image(part)] + ([] if self.ground is None else [self.ground])

    @property
    def feels_planes(self) -> bool:
        """True if anything depends on ground or walls that are near."""
        return self.ground is not None or any(map(feels_planes, [*self.terms.values(), *self.actuators.values()]))

    @property
    def feels_depth(self) -> bool:
        """True if anything depends on the ground, be walls near or not."""
        return self.ground is not None or any(map(feels_depth, [*self.terms.values(), *self.actuators.values()]))

    @property
    def carriers(self) -> dict[str, Carrier]:
        """Actuators that carry mass, by name."""
        return carriers_of(self.actuators)

    def growth(
        self, flow: Flow, states: Sequence[Array], command: Sequence[Array], h: Array
    ) -> list[list[Array]] | None:
        """Growth of the mass matrix `(6, 6)` a second by what comes aboard within h [s]; None where nothing can."""
        carriers = self.carriers
        if not carriers:
            return None
        now = dict(zip(self.actuators, states, strict=False))
        after = dict(zip(self.actuators, self.advanced(states, command, h, flow), strict=False))
        return growth_of([(carrier, now[name], after[name]) for name, carrier in carriers.items()], flow, h)

    def limited(self, actuators: Sequence[Array]) -> list[Array]:
        """Actuator states as forces see them."""
        return [a.lag.limited(s) for a, s in zip(self.actuators.values(), actuators, strict=False)]

    @property
    def kept(self) -> int:
        """Number of values that actuators keep beside their states."""
        return sum(a.lag.memory for a in self.actuators.values())

    def rates(self, actuators: Sequence[Array], command: Sequence[Array], flow: Flow | None = None) -> list[Array]:
        """Time derivative of the actuator states, see `Lag.rate`; `flow`: for those that depend on it."""
        return self._each(actuators, flow, lambda lag, i, state, kept: lag.rates(state, kept, command[i]))

    def advanced(
        self, actuators: Sequence[Array], command: Sequence[Array], h: Array, flow: Flow | None = None
    ) -> list[Array]:
        """Actuator states after h [s] of a constant command; `flow`: for those that depend on it."""
        return self._each(actuators, flow, lambda lag, i, state, kept: lag.after(state, kept, command[i], h))

    def _each(
        self,
        actuators: Sequence[Array],
        flow: Flow | None,
        of: Callable[[Follower, int, Array, list[Array]], list[Array]],
    ) -> list[Array]:
        """`of(follower, number, state, kept)` of every actuator: states first, then what is kept."""
        states: list[Array] = []
        further: list[Array] = []
        rest = list(actuators[len(self.actuators) :])
        for i, actuator in enumerate(self.actuators.values()):
            mine, rest = rest[: actuator.lag.memory], rest[actuator.lag.memory :]
            law = actuator.lag if flow is None or not isinstance(actuator, Carrier) else actuator.follower(flow)
            state, *kept = of(law, i, actuators[i], mine)
            states.append(state)
            further += kept
        return states + further


def inertia_of(body: Body, coriolis: CoriolisConfig) -> Inertia:
    """The inertia of a body; its mass matrix is inverted here, once, in double precision."""
    parts = None
    excess = body.rigid - body.displaced
    if coriolis.rigid == "angular":
        mass = float(body.rigid[0, 0])
        shift = transport(body.center_of_gravity)
        inside = np.linalg.inv(shift)
        about_cg = (inside.T @ body.rigid @ inside)[3:, 3:]
        parts = (mass, numbers(about_cg), numbers(shift))
    return Inertia(
        rigid=numbers(body.rigid),
        added=numbers(body.added),
        inverse=numbers(np.linalg.inv(body.mass_matrix)),
        without=EVERY if coriolis.added == "none" else tuple((row - 1, col - 1) for row, col in coriolis.without),
        angular=parts,
        none=coriolis.rigid == "none",
        displaced=None if body.stiffness.any() else numbers(body.displaced),
        symmetric=bool(np.array_equal(body.mass_matrix, body.mass_matrix.T)),
        excess=numbers(excess)
        if not body.stiffness.any() and np.abs(excess).max() > _NEUTRAL * np.abs(body.rigid).max()
        else None,
    )
