"""A vehicle: its model, its control modes and its hull, for fleets of any size."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from functools import cached_property
from importlib import import_module
from pathlib import Path
from typing import Any

import drjit as dr
import numpy as np
from numpy.typing import ArrayLike, NDArray

from pelagos import jit
from pelagos.errors import CommandError, LookupFailed
from pelagos.hydro.algebra import Vector, add, minus, scaled
from pelagos.jit import Array
from pelagos.math import so3
from pelagos.math.frames import flip_quaternion_np, flip_yz_np
from pelagos.raycast.geometry import Geometry
from pelagos.vehicles.actuators.t200 import t200_tables
from pelagos.vehicles.around import flow_around
from pelagos.vehicles.books import Accelerations
from pelagos.vehicles.build import build_model, build_modes
from pelagos.vehicles.config import VehicleConfig
from pelagos.vehicles.control.besides import Besides
from pelagos.vehicles.control.controller import Controller, Demand
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.integrate import Rigid, runge_kutta, semi_implicit
from pelagos.vehicles.load import merged
from pelagos.vehicles.model import Model
from pelagos.vehicles.read_config import checked_config, read_config
from pelagos.vehicles.shape.hull import build_hull, hull_materials
from pelagos.vehicles.state import StateSizes, VehicleState
from pelagos.vehicles.tables import Tables

__all__ = ["Vehicle", "VehicleConfig"]

Wrench = tuple[Array, Array]


class Vehicle:
    """A vehicle, compiled from its configuration; it has no state of its own.

    Attributes:
        config: what it was made from.
        model: the equation of motion.
        controllers: control modes by name.
    """

    def __init__(self, config: VehicleConfig) -> None:
        self.config = config
        self.model = build_model(config)
        self.controllers = build_modes(config, self.model)
        self._memory = max((c.memory for c in self.controllers.values()), default=0)
        self._mode_number = {name: i + 1.0 for i, name in enumerate(self.controllers)}

    @classmethod
    def from_catalogue(cls, name: str, **changes: Any) -> Vehicle:
        """A vehicle of the catalogue, with changes to its configuration.

        Raises:
            LookupFailed: no such vehicle.
            ScenarioError: a change that cannot be.
        """
        from pelagos.vehicles.load import catalogue_names

        if name not in catalogue_names():
            raise LookupFailed("vehicle", name, catalogue_names())
        return cls.from_dict({"type": name, **changes})

    @classmethod
    def from_dict(cls, data: Mapping[str, Any], *, where: str = "") -> Vehicle:
        """From the mapping that a scenario writes under `vehicle:`.

        Raises:
            ScenarioError: names the key, what was given and why it cannot be.
        """
        return cls(checked_config(dict(data), where=where or f"vehicle {data.get('type', '?')}"))

    @classmethod
    def from_yaml(cls, path: str | Path, *, trust: bool = False) -> Vehicle:
        """From a YAML file with the keys of `VehicleConfig`.

        Args:
            path: of the file.
            trust: let it name functions of Python to call ("module:function"): such a file is a program.

        Raises:
            ScenarioError: the file cannot be read, a key cannot be, or it names a function and is not trusted.
        """
        return cls(read_config(path, trust=trust))

    @classmethod
    def from_config(cls, config: VehicleConfig) -> Vehicle:
        """From a validated configuration."""
        return cls(config)

    def with_model(self, model: Model) -> Vehicle:
        """This vehicle with another equation of motion, such as one whose numbers are arrays."""
        other = copy(self)
        other.model = model
        return other

    def _repr_html_(self) -> str:
        return str(import_module("pelagos.drawing.notebook").vehicle_html(self))

    # names

    @property
    def name(self) -> str:
        """Its name in the catalogue, or "custom"."""
        return self.config.type

    @property
    def actuator_names(self) -> tuple[str, ...]:
        """In the order of states and commands."""
        return tuple(self.model.actuators)

    @property
    def modes(self) -> tuple[str, ...]:
        """Control modes."""
        return tuple(self.controllers)

    @property
    def default_mode(self) -> str:
        """The mode that commands are for when none is chosen."""
        return self.config.default_mode

    def command_names(self, mode: str | None = None) -> tuple[str, ...]:
        """Names of the set-points of a mode, in order.

        Raises:
            LookupFailed: no such mode.
        """
        return self._controller(mode or self.default_mode).commands

    def set_points(self, mode: str) -> tuple[str, ...]:
        """Names of a mode's own set-points, which those of what the vehicle carries follow; see `command_names`."""
        controller = self._controller(mode)
        return controller.mode.commands if isinstance(controller, Besides) else controller.commands

    # the books' face

    @cached_property
    def published(self) -> Vehicle:
        """The model exactly as published, where the catalogue deviates from it."""
        if not self.config.as_published:
            return self
        data = self.config.model_dump(exclude={"as_published"})
        return Vehicle(VehicleConfig.model_validate(merged(data, {**self.config.as_published, "as_published": {}})))

    @cached_property
    def _accelerations(self) -> Accelerations:
        return Accelerations(self.published)

    def accelerations(
        self,
        eta: ArrayLike,
        nu: ArrayLike,
        actuators: ArrayLike,
        command: ArrayLike,
        current: ArrayLike = (0.0, 0.0, 0.0),
        walls: ArrayLike = (),
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Accelerations of the model as published, NED and FRD as the books have it.

        Args:
            eta: `(n, 6)` x, y, z NED [m], phi, theta, psi [rad].
            nu: `(n, 6)` over ground [m/s], [rad/s].
            actuators: `(n, k)` states, in the order of `actuator_names`, and behind them what some keep beside.
            command: `(n, k)` commands to them.
            current: `(3,)` or `(n, 3)` velocity of the water, NED [m/s].
            walls: `(k, 4)` unit normal NED towards the vehicle, and distance of its origin [m]; ships feel ground.

        Returns:
            nu_dot `(n, 6)`, and the rate of the actuators' states `(n, k)`; beyond its limits one is back in 1 s.

        Raises:
            CommandError: a wrong shape, or a value that is not finite.
        """
        return self._accelerations(eta, nu, actuators, command, current, walls)

    # the simulator's face

    def initial_state(
        self,
        position: NDArray[np.float64],
        attitude: NDArray[np.float64],
        velocity: NDArray[np.float64] | None = None,
        angular_velocity: NDArray[np.float64] | None = None,
    ) -> VehicleState:
        """A fleet at `position` `(n, 3)` NWU, `attitude` `(n, 4)` FLU -> NWU, velocities `(n, 3)` FLU."""
        n, still = len(position), np.zeros((len(position), 3))
        zero = [dr.zeros(jit.Array3f64, n) for _ in range(5)]
        state = VehicleState(
            position=zero[0],
            attitude=jit.Array4f64(1.0, 0.0, 0.0, 0.0),
            velocity=zero[1],
            angular_velocity=zero[2],
            acceleration=zero[3],
            angular_acceleration=zero[4],
            **self.sizes.lists([dr.zeros(jit.Float64, n) for _ in range(self.sizes.kept)]),
            mode=dr.zeros(jit.Float64, n),
            controller=[dr.zeros(jit.Float64, n) for _ in range(self._memory)],
        )
        return self.place(
            state,
            position=position,
            attitude=attitude,
            velocity=still if velocity is None else velocity,
            angular_velocity=still if angular_velocity is None else angular_velocity,
        )

    def place(self, state: VehicleState, **parts: NDArray[np.float64]) -> VehicleState:
        """`state` with other `position`, `attitude`, `velocity` or `angular_velocity` `(n, ...)`, NWU and FLU.

        Controllers start anew, from the new place; accelerations are 0 until the next step.
        """
        n = dr.width(state.mode)
        new = dict(vars(state))
        for name, values in parts.items():
            if name == "attitude":
                unit = values / np.linalg.norm(values, axis=-1, keepdims=True)
                new[name] = jit.Array4f64(np.ascontiguousarray(flip_quaternion_np(unit).T))
            else:
                new[name] = jit.Array3f64(np.ascontiguousarray(flip_yz_np(values).T))
            jit.align(new[name])
        new["acceleration"], new["angular_acceleration"] = dr.zeros(jit.Array3f64, n), dr.zeros(jit.Array3f64, n)
        new["mode"], new["controller"] = dr.zeros(jit.Float64, n), [dr.zeros(jit.Float64, n) for _ in state.controller]
        placed = VehicleState(**new)
        dr.make_opaque(placed)
        return placed

    def check_mode(self, mode: str) -> None:
        """A state goes on in any mode: a step starts a mode's memory by itself when another mode ran before.

        Raises:
            LookupFailed: no such mode.
        """
        self._controller(mode)

    def step(
        self,
        state: VehicleState,
        command: Sequence[Array],
        ocean: Any,
        t: Array,
        wrench: Wrench,
        h: Array,
        mode: str,
        tables: Tables | None = None,
    ) -> VehicleState:
        """The state after h [s]: control law, forces, motion, actuators. Pure; may be frozen or looped symbolically.

        Args:
            state: of the fleet.
            command: set-points of the mode, `Float64` each.
            ocean: currents and surface (`ocean.ocean.Ocean`), or None for still water.
            t: time at the step's beginning [s].
            wrench: a further force and moment about the origin, FRD (two `Array3f64`) [N], [N m].
            h: step [s].
            mode: of `modes`.
            tables: `Vehicle.tables`; a frozen function must be handed them as an argument.
        """
        tables = self._needed(tables, ocean)
        rigid = Rigid([*state.position], state.attitude, [*state.velocity, *state.angular_velocity])
        flow = self._flow_of_step(rigid, state, ocean, t, h, tables)
        controller = self._controller(mode)
        memory = self._begin(state, controller, mode, flow)
        demand, kept = controller.act(memory, flow, list(command), h)
        commands = [jit.Float64(demand.actuators.get(name, 0.0)) for name in self.model.actuators]
        outside, radiation = self._outside(state, flow, demand, wrench, h)
        moved = [*state.actuators, *state.actuator_memory]
        growth = self.model.growth(flow, moved, commands, h)

        def accelerate(at: Rigid, fraction: float) -> Vector:
            if demand.acceleration is not None:  # contact, and what pushes from outside, besides
                mass = self.model.inertia_in(self.model.acted(flow, self.model.limited(moved)))
                return add(demand.acceleration, mass.accelerate([*wrench[0], *wrench[1]]))
            here = flow if fraction == 0.0 else self.flow(at, ocean, t + fraction * h, tables)
            here.step, here.growth = None if self.config.integrator == "runge_kutta" else h, growth
            states = moved if fraction == 0.0 else self.model.advanced(moved, commands, fraction * h, flow)
            over = h if self.config.integrator == "conservative" else None
            return self.model.nu_dot(here, self.model.limited(states), outside, tables, over)

        if self.config.integrator == "runge_kutta":
            new, nu_dot = runge_kutta(rigid, accelerate, h, so3.matrix)
        else:
            new, nu_dot = semi_implicit(rigid, accelerate, flow.rotation, h)
        moved = [jit.Float64(a) for a in [*self.model.advanced(moved, commands, h, flow), *radiation]]
        return VehicleState(
            position=jit.Array3f64(*new.position),
            attitude=new.attitude,
            velocity=jit.Array3f64(*new.nu[:3]),
            angular_velocity=jit.Array3f64(*new.nu[3:]),
            acceleration=jit.Array3f64(*nu_dot[:3]),
            angular_acceleration=jit.Array3f64(*nu_dot[3:]),
            **self.sizes.lists(moved),
            mode=jit.Float64(self._mode_number[mode]),
            controller=[*(jit.Float64(m) for m in kept), *state.controller[len(kept) :]],
        )

    def _flow_of_step(
        self, rigid: Rigid, state: VehicleState, ocean: Any, t: Array, h: Array, tables: Tables | None
    ) -> Flow:
        """The water around a vehicle at the beginning of a step, and the velocity in its middle where that counts."""
        flow = self.flow(rigid, ocean, t, tables)
        flow.step = h
        if self.config.integrator == "conservative":
            gone = [*state.acceleration, *state.angular_acceleration]  # as the last step had it, the next will nearly
            gone = add(gone[:3], minus(flow.current_rate[:3])) + gone[3:]
            flow.midway = add(flow.nu_c, scaled(0.5 * h, gone))
        return flow

    def _needed(self, tables: Tables | None, ocean: Any) -> Tables | None:
        """The tables of a step, if it takes any."""
        wavy = self.model.sea is not None and getattr(ocean, "waves", None) is not None
        if tables is not None or not (self.model.battery is not None or wavy):
            return tables
        if dr.flag(dr.JitFlag.FreezingScope):
            raise CommandError(f"a frozen step of {self.name} must be handed `Vehicle.tables` as an argument")
        return self.tables

    def _outside(
        self, state: VehicleState, flow: Flow, demand: Demand, wrench: Wrench, h: Array
    ) -> tuple[list[Array], list[Array]]:
        """Wrench beside the model's terms (6): that given, that demanded, and that of waves which the hull
        radiated; and the memory of these waves after the step.
        """
        outside = [*wrench[0], *wrench[1]]
        if demand.wrench is not None:
            outside = [a + b for a, b in zip(outside, demand.wrench, strict=True)]
        sea = self.model.sea
        if sea is None:
            return outside, []
        if flow.seaway is None:
            return outside, state.radiation
        memory, radiation = sea.remember(state.radiation, flow.seaway.velocity, h)
        return add(outside, radiation, sea.load_at_speed(state.radiation, memory, flow)), memory

    @property
    def sizes(self) -> StateSizes:
        """Lengths of the lists of a state."""
        sea = self.model.sea
        return StateSizes(len(self.model.actuators), self.model.kept, 0 if sea is None else sea.memory)

    @cached_property
    def tables(self) -> Tables | None:
        """Tables that a step reads on the device; None for most vehicles."""
        battery, sea = self.config.battery, self.model.sea
        if battery is None and sea is None:
            return None
        thrusters = None if battery is None else t200_tables(battery.open_circuit_v)
        return Tables(thrusters, None if sea is None else sea.table())

    def flow(self, rigid: Rigid, ocean: Any, t: Array, tables: Tables | None = None) -> Flow:
        """The water around a vehicle: current, waves, surface and wind above."""
        if tables is None and self.model.sea is not None:
            tables = self.tables
        return flow_around(self.config, self.model, rigid, ocean, t, tables)

    def _begin(self, state: VehicleState, controller: Controller, mode: str, flow: Flow) -> list[Array]:
        """The mode's memory: what it kept, or its start where another mode ran before."""
        same = state.mode == self._mode_number[mode]
        return [dr.select(same, old, new) for old, new in zip(state.controller, controller.start(flow), strict=False)]

    def _controller(self, mode: str) -> Controller:
        if mode not in self.controllers:
            raise LookupFailed("control mode", mode, self.controllers, where=f"vehicle {self.name}")
        return self.controllers[mode]

    # shape

    @cached_property
    def hull(self) -> Geometry:
        """The mesh, body FLU; its materials are rows of `materials`."""
        return build_hull(self.config.shape, self.name, self.materials)

    @cached_property
    def probes(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Contact probes: starts `(p, 3)` inside the hull and vectors `(p, 3)` to its surface, body FLU [m]."""
        return self.config.shape.probes()

    @cached_property
    def bounding_radius_m(self) -> float:
        """Radius of the sphere about the origin that holds the hull [m]."""
        return float(np.linalg.norm(self.hull.vertices, axis=1).max())

    @cached_property
    def materials(self) -> tuple[str, ...]:
        """Materials of the hull, by name."""
        return hull_materials(self.config.shape, self.config.materials)
