"""Blue Robotics T200 thrusters by the maker's measured tables, fed by a battery whose voltage sags.

Source: Blue Robotics, "T200 Public Performance Data 10-20V, September 2019" (bollard thrust, Basic ESC), `t200.csv`:
every published number, unsmoothed. The table is static; what lags is the throttle.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Final, Literal, Self

import drjit as dr
import numpy as np
from numpy.typing import NDArray
from pydantic import model_validator

from pelagos import jit
from pelagos.hydro.algebra import Vector, mul
from pelagos.jit import Array
from pelagos.vehicles.actuators.inflow import DiscOnly, Inflow, build_inflow, check_direction
from pelagos.vehicles.actuators.lag import Lag
from pelagos.vehicles.actuators.third_order import VON_BENZON, Modes, ThirdOrder
from pelagos.vehicles.actuators.thruster import deduction_of, thrust_effect
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import Body, NonNegative, Number, PartConfig, Positive, Three
from pelagos.vehicles.wetness import HULL, Place

NEWTON_PER_KGF: Final = 9.80665
VOLTAGES: Final = (10.0, 12.0, 14.0, 16.0, 18.0, 20.0)
PULSES: Final = 201  # 1100 to 1900 us in steps of 4 us
_NEUTRAL_US: Final = 1500.0
_SPAN_US: Final = 400.0


@cache
def measured() -> NDArray[np.float64]:
    """The maker's table `(6, 201, 7)` by voltage and pulse width.

    Columns: pulse [us], speed [rpm], current [A], voltage [V], power [W], force [kgf], efficiency [gf/W].
    """
    text = (files("pelagos.vehicles.actuators") / "t200.csv").read_text(encoding="utf-8")
    rows = np.array([[float(x) for x in line.split(",")] for line in text.splitlines()[1:]])
    return rows.reshape(len(VOLTAGES), PULSES, -1)


class BatteryConfig(PartConfig):
    """Battery of the thrusters: its voltage falls with the current that they draw."""

    open_circuit_v: Positive
    """Without load [V]; the tables reach from 10 to 20 V."""
    resistance_ohm: NonNegative
    """Of the battery and its leads [ohm]."""


class T200Config(PartConfig):
    """Command and state: throttle, -1 .. 1 for pulses of 1100 .. 1900 us."""

    type: Literal["t200"]
    position_m: Three
    """FRD from the origin [m]."""
    direction: Three
    """Of positive thrust, FRD; its length does not matter."""
    torque_m: Number = 0.0
    """Reaction torque about `direction` by thrust [m]; its sign is that of the propeller's hand."""
    dynamics: Literal["first_order", "third_order"] = "first_order"
    """How the throttle follows: with `time_constant_s`, or by von Benzon's transfer function for the T200."""
    time_constant_s: NonNegative
    """Of the first order [s]."""
    nominal_v: Positive = 16.0
    """Voltage at which control laws turn a thrust into a throttle [V]."""
    inflow: DiscOnly | None = None
    """Loss of thrust in the water that flows through it; left out: the bollard thrust of the tables at any speed."""

    @model_validator(mode="after")
    def _possible(self) -> Self:
        check_direction(self.direction)
        return self

    def build(self, body: Body) -> T200:
        """The actuator."""
        return T200(
            effect=thrust_effect(self.position_m, self.direction, self.torque_m, deduction_of(self.inflow)),
            lag=self._follower,
            inverse=inverse_fit(self.nominal_v),
            site=Place("propeller", self.position_m, _RADIUS),
            inflow=build_inflow(
                self.inflow, position=self.position_m, direction=self.direction, diameter=2 * _RADIUS,
                density=body.density,
            ),
        )  # fmt: skip

    @property
    def _follower(self) -> Lag | ThirdOrder:
        if self.dynamics == "third_order":
            return ThirdOrder(Modes.of(*VON_BENZON), -1.0, 1.0)
        return Lag(self.time_constant_s, -1.0, 1.0)


@dataclass(frozen=True)
class Side:
    """Throttle for a thrust on one side: dead + root sqrt(F) + linear F; limit: largest thrust [N]."""

    dead: float
    root: float
    linear: float
    limit: float


_RADIUS: Final = 0.038  # of the propeller [m]: 3 inch


@cache
def inverse_fit(voltage: float) -> tuple[Side, Side]:
    """Least-squares inverse of the table at a voltage, astern and ahead, for control laws."""
    table = np.array([np.interp(voltage, VOLTAGES, column) for column in measured()[:, :, 5].T]) * NEWTON_PER_KGF
    throttle = _steps()
    sides = []
    for sign in (-1, 1):
        chosen = (sign * throttle > 0) & (table != 0)
        size, force = np.abs(throttle[chosen]), np.abs(table[chosen])
        basis = np.stack([np.ones_like(force), np.sqrt(force), force], axis=-1)
        dead, root, linear = np.linalg.lstsq(basis, size, rcond=None)[0]
        sides.append(Side(float(dead), float(root), float(linear), float(force.max())))
    return sides[0], sides[1]


@jit.struct
class T200Tables:
    """The tables on the device, a Dr.Jit struct.

    Attributes:
        force: `Float64`, four corners [N] of every cell (voltage, pulse), packed.
        current: `Float64`, two ends [A] of every interval of pulses at the battery's open-circuit voltage, packed.
    """

    force: Array
    current: Array


def t200_tables(open_circuit: float) -> T200Tables:
    """The device tables for a battery."""
    force = measured()[:, :, 5] * NEWTON_PER_KGF
    corners = np.stack([force[:-1, :-1], force[:-1, 1:], force[1:, :-1], force[1:, 1:]], axis=-1)
    current = np.array([np.interp(open_circuit, VOLTAGES, column) for column in measured()[:, :, 2].T])
    ends = np.stack([current[:-1], current[1:]], axis=-1)
    tables = T200Tables(jit.Float64(corners.ravel()), jit.Float64(ends.ravel()))
    jit.align(tables)
    return tables


@dataclass(frozen=True)
class Battery:
    """open_circuit [V], resistance [ohm], exponent: of current against voltage at constant throttle [-]."""

    open_circuit: Array
    resistance: Array
    exponent: float

    def voltage(self, throttles: list[Array], tables: T200Tables) -> Array:
        """Under the load of all thrusters [V].

        V = E - R I(V) with I = I(E) (V/E)^exponent, its power linear about E: exact to 0.2 % of R I at 10 % of sag.
        """
        drawn: Array = 0.0
        for throttle in throttles:
            at, share = _place(throttle)
            ends = dr.gather(jit.Array2f64, tables.current, at)
            drawn = drawn + ends[0] + share * (ends[1] - ends[0])
        drop = self.resistance * drawn
        return (self.open_circuit - (1 - self.exponent) * drop) / (1 + self.exponent * drop / self.open_circuit)


def load(battery: Battery, throttles: NDArray[np.float64]) -> tuple[float, float]:
    """Voltage [V] and drawn current I(E) (V/E)^exponent [A] at throttles `(k,)`; see `Battery.voltage`."""
    whole = float(battery.open_circuit)
    table = np.array([np.interp(whole, VOLTAGES, column) for column in measured()[:, :, 2].T])
    drawn = float(np.interp(np.clip(throttles, -1.0, 1.0), _steps(), table).sum())
    voltage = battery.voltage([jit.Float64(float(throttle)) for throttle in throttles], t200_tables(whole))
    terminal = float(np.array(voltage).ravel()[0]) if len(throttles) else whole
    return terminal, drawn * (terminal / whole) ** battery.exponent


def shaft_speed(throttle: float, voltage: float) -> float:
    """Speed of the shaft [rad/s] at a throttle and a voltage [V], linear between the table's points, held beyond them.

    The table has no sign: the propeller turns the way of the throttle.
    """
    rpm = [np.interp(np.clip(throttle, -1.0, 1.0), _steps(), row) for row in measured()[:, :, 1]]
    return float(np.copysign(np.interp(voltage, VOLTAGES, rpm) * 2 * np.pi / 60, throttle))


def _steps() -> NDArray[np.float64]:
    """`(201,)` throttles of the table's pulse widths."""
    return (measured()[0, :, 0] - _NEUTRAL_US) / _SPAN_US


@cache
def current_exponent() -> float:
    """Exponent of current against voltage at constant pulse width, fitted to the table where more than 1 A flows."""
    current = measured()[:, :, 2]
    chosen = (current > 1).all(axis=0)
    slopes = np.polyfit(np.log(VOLTAGES), np.log(current[:, chosen]), 1)[0]
    return float(np.median(slopes))


def table_thrust(throttle: Array, voltage: Array, tables: T200Tables) -> Array:
    """Thrust [N] at a throttle and supply voltage [V], linear between the table's points, held beyond them."""
    at, share = _place(throttle)
    height = dr.clip((voltage - VOLTAGES[0]) * 0.5, 0.0, len(VOLTAGES) - 1.0)
    row = dr.minimum(dr.floor(height), len(VOLTAGES) - 2.0)
    cell = dr.minimum(jit.UInt32(row), len(VOLTAGES) - 2) * (PULSES - 1) + at
    c = dr.gather(jit.Array4f64, tables.force, cell)
    low, high = c[0] + share * (c[1] - c[0]), c[2] + share * (c[3] - c[2])
    return low + (height - row) * (high - low)


def _place(throttle: Array) -> tuple[Array, Array]:
    """Interval of the table, also of what is not a number, and the share of it passed."""
    steps = dr.clip(throttle, -1.0, 1.0) * ((PULSES - 1) / 2) + (PULSES - 1) / 2
    first = dr.minimum(dr.floor(steps), PULSES - 2.0)
    return dr.minimum(jit.UInt32(first), PULSES - 2), steps - first


@dataclass(frozen=True)
class T200:
    """effect: wrench (6) of 1 N of thrust; inverse: throttle by thrust, astern and ahead; inflow: what it loses in a
    flow, None: nothing.
    """

    effect: Vector
    lag: Lag | ThirdOrder
    inverse: tuple[Side, Side]
    unit: str = "throttle"
    site: Place = HULL
    inflow: Inflow | None = None

    def thrust(self, state: Array, flow: Flow) -> Array:
        """At rest, at a throttle and the battery's voltage [N]."""
        assert flow.supply is not None
        return table_thrust(state, flow.supply.voltage, flow.supply.tables)

    def wrench(self, state: Array, flow: Flow) -> Vector:
        """Force and moment (6)."""
        thrust = self.thrust(state, flow)
        if self.inflow is not None:
            return self.inflow.wrench(self.effect, thrust, state, flow)
        return [mul(e, thrust) for e in self.effect]

    @property
    def thrust_limits(self) -> tuple[float, float]:
        """Largest thrust [N] astern (negative) and ahead, at the nominal voltage."""
        return -self.inverse[0].limit, self.inverse[1].limit

    def command(self, thrust: Array) -> Array:
        """The throttle for a thrust [N] at the nominal voltage; none for less than 0.1 N, inside the dead-band."""
        size = dr.abs(thrust)
        back, ahead = (s.dead + s.root * dr.sqrt(size) + s.linear * size for s in self.inverse)
        throttle = dr.select(thrust > 0, ahead, -back)
        return dr.select(size < 0.1, 0.0, dr.clip(throttle, -1.0, 1.0))
