"""Steps of a manoeuvre: the helm that it may order, what counts as held, thrusters by their way."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pelagos.errors import InputError
from pelagos.manoeuvres import approach, standard
from pelagos.manoeuvres.calm_run import CalmRun
from pelagos.manoeuvres.orders import Orders, check
from pelagos.manoeuvres.standard import _felt, _way, _ways
from pelagos.vehicles.actuators.engine import ShipEngine
from pelagos.vehicles.actuators.nomoto import NomotoShip


def rows(speeds: Any = (), rates: Any = ()) -> list[np.ndarray]:
    """Rows of a run: speed ahead in the eighth column, yaw rate in the thirteenth."""
    count = max(len(speeds), len(rates))
    table = np.random.default_rng(2).normal(size=(count, 15))
    table[:, 7] = speeds if len(speeds) else 0.0
    table[:, 12] = rates if len(rates) else 0.0
    return list(table)


def run(**parts: Any) -> Any:
    made = SimpleNamespace(length=6.0, rate_hz=10, **parts)
    if "rows" in parts:
        made.now = CalmRun.now.fget(made)  # type: ignore[attr-defined]
    return made


def test_a_row_is_a_moment() -> None:
    table = rows([1.0, 2.5])
    table[-1][0], table[-1][6] = 0.7, -1.1
    assert vars(run(rows=table).now) == {"time": 0.7, "yaw": -1.1, "ahead": 2.5}


@pytest.mark.parametrize(("gain", "held"), [(0.009, True), (0.011, False), (-0.2, True)])
def test_a_speed_is_held_that_gained_little_in_its_last_length(gain: float, held: bool) -> None:
    """6 m at 2 m/s are 3 s, 30 rows of a tenth of a second: by 0.5 % of 2 m/s at most."""
    speeds = np.concatenate([np.full(20, 0.5), np.full(1, 2.0 - gain), np.linspace(2.0 - gain, 2.0, 30)])
    assert CalmRun.holds_speed(run(rows=rows(speeds))) == held
    assert not CalmRun.holds_speed(run(rows=rows(np.full(30, 2.0))))  # it has not gone so far
    assert CalmRun.holds_speed(run(rows=rows(np.full(31, 2.0))))


def test_a_mean_yaw_rate_is_of_the_last_seconds() -> None:
    made = run(rows=rows(rates=[9.0, 9.0, 0.01, 0.03, -0.07]))
    assert CalmRun.mean_yaw_rate(made, 0.3) == pytest.approx(math.degrees(-0.01))
    assert CalmRun.mean_yaw_rate(made, 0.01) == pytest.approx(math.degrees(-0.07))


def ship(low: float, high: float) -> Any:
    rudder = object.__new__(NomotoShip)
    object.__setattr__(rudder, "lag", SimpleNamespace(low=math.radians(low), high=math.radians(high)))
    other = SimpleNamespace(lag=SimpleNamespace(low=-9.0, high=9.0))
    model = SimpleNamespace(actuators={"fin": other, "rudder": rudder})
    made = run(vehicle=SimpleNamespace(model=model, name="it", actuator_names=("fin", "rudder")))
    made.helm = lambda most: CalmRun.helm(made, most)
    return made


def test_a_helm_is_that_of_the_rudder_and_full_helm_35_degrees_at_most() -> None:
    made = ship(-20.0, 30.0)
    assert [made.helm(d) for d in (-20.0, 0.0, 30.0)] == [1, 1, 1]
    for beyond in (-20.01, 30.01):
        with pytest.raises(InputError, match=r"--rudder .*: the rudder of it goes from -20 to 30 deg"):
            made.helm(beyond)
    assert CalmRun.full_helm(made) == pytest.approx(30.0)
    assert CalmRun.full_helm(ship(-40.0, 40.0)) == pytest.approx(35.0)
    made.vehicle.model.actuators.pop("rudder")
    with pytest.raises(InputError, match=r"no ship's rudder \(actuators: fin, rudder\)"):
        made.helm(0.0)


@pytest.mark.parametrize(
    ("effect", "way", "limits"),
    [
        ((0.6, 0.7, -0.1), ("astern", "ahead"), ("astern", "ahead")),
        ((-0.6, 0.7, -0.1), ("astern", "ahead"), ("ahead", "astern")),
        ((0.4, -0.7, 0.6), ("to port", "to starboard"), ("to starboard", "to port")),
        ((0.4, 0.6, 0.7), ("up", "down"), ("up", "down")),
        ((0.1, -0.2, -0.9), ("up", "down"), ("down", "up")),
    ],
)
def test_a_thruster_has_the_way_of_most_of_its_push(effect: Any, way: tuple[str, str], limits: tuple[str, str]) -> None:
    """Along the hull from half of it on; words for the push at its lower and its upper limit. FRD: z is down."""
    actuator = SimpleNamespace(effect=(*effect, 5.0, -6.0, 7.0))
    assert _way(actuator) == way
    assert _ways(actuator) == limits


def test_thrust_is_felt_less_what_the_hull_takes() -> None:
    assert _felt(SimpleNamespace(inflow=SimpleNamespace(deduction=0.15))) == pytest.approx(0.85)
    assert _felt(SimpleNamespace(inflow=None)) == 1.0
    assert _felt(SimpleNamespace()) == 1.0


def test_a_jet_is_told_where_it_takes_a_hundredth(monkeypatch: pytest.MonkeyPatch) -> None:
    """At each pair of limits, source first; words of the target's push and the source's."""
    ahead = SimpleNamespace(thrust_limits=(-3.0, 5.0), effect=(1.0, 0, 0, 0, 0, 0))
    aside = SimpleNamespace(thrust_limits=(-7.0, 11.0), effect=(0, -1.0, 0, 0, 0, 0))
    left = {(-3.0, -7.0): 0.8, (-3.0, 11.0): 0.995, (5.0, -7.0): 0.989, (5.0, 11.0): 1.0}
    jets = SimpleNamespace(
        jets=(SimpleNamespace(source="a", target="b"),), left=lambda parts, jet, *, source, target: left[source, target]
    )
    model: Any = SimpleNamespace(actuators={"a": ahead, "b": aside}, interaction=jets)
    found = standard._jet_losses(model)
    assert [(m.name, m.unit) for m in found] == [
        ("b to starboard, lost in the jet of a astern", "%"), ("b to starboard, lost in the jet of a ahead", "%"),
    ]  # fmt: skip
    assert [m.value for m in found] == pytest.approx([20.0, 1.1])
    assert standard._jet_losses(SimpleNamespace(interaction=None)) == []  # type: ignore[arg-type]


def engine(service: float, high: float) -> Any:
    made = object.__new__(ShipEngine)
    object.__setattr__(made, "service", service)
    object.__setattr__(made, "lag", SimpleNamespace(high=high, low=0.0))
    return made


def test_a_speed_is_held_where_the_gain_is_nought(monkeypatch: pytest.MonkeyPatch) -> None:
    """The largest speed of a gain that falls with the speed; revolutions that all have the same share of service."""
    asked: list[Any] = []

    def surge(ship: Any, speed: Any, states: np.ndarray, depth: Any) -> np.ndarray:
        asked.append((speed, states.copy(), depth))
        return 0.02 * states[:, 1] ** 2 - 0.01 * np.broadcast_to(speed, len(states)) ** 2

    monkeypatch.setattr(approach, "_surge", surge)
    states = np.array([[7.0, 3.0, 1.0]])
    ship: Any = SimpleNamespace(
        name="it", model=SimpleNamespace(actuators={"r": None, "a": engine(3.0, 6.0), "b": engine(2.0, 3.0)})
    )
    assert approach._held_speed(ship, 8.0, states, 12.0) == pytest.approx(math.sqrt(18.0), rel=1e-5)
    assert asked[-1][2] == 12.0
    assert approach._held_speed(ship, 4.0, states, 12.0) == 4.0  # it would gain: no more than that is asked for
    found = approach._ordered(ship, 4.0, states, {1: 3.0, 2: 2.0}, None)
    assert found == pytest.approx({1: math.sqrt(8.0), 2: math.sqrt(8.0) * 2 / 3}, rel=1e-5)
    tried = asked[-1][1]
    assert (tried[:, 0] == 7.0).all()
    assert tried[:, 1] * 2 == pytest.approx(tried[:, 2] * 3)
    assert tried[-1, 2] == pytest.approx(3.0)  # as far as the weaker one turns
    with pytest.raises(InputError, match=r"--speed 7: the engine of it does not hold it at its largest revolutions"):
        approach._ordered(ship, 7.0, states, {1: 3.0, 2: 2.0}, None)


def test_a_first_speed_is_the_ordered_one_or_the_largest_or_that_of_cruising() -> None:
    def of(top: float | None, ordered: float | None = None) -> float:
        envelope = SimpleNamespace(top_mps=top, cruise_mps=1.5)
        ship: Any = SimpleNamespace(name="it", config=SimpleNamespace(envelope=envelope))
        return approach.first_speed(ship, Orders(speed_m_s=ordered))

    assert (of(None), of(4.0), of(4.0, 2.5), of(None, 9.0), of(4.0, 4.0)) == (1.5, 4.0, 2.5, 9.0, 4.0)
    with pytest.raises(InputError, match=r"--speed 4\.1: it makes at most 4 m/s"):
        of(4.0, 4.1)


def test_other_keys_of_an_actuator_leave_the_rest() -> None:
    vehicle = {"type": "it", "actuators": {"a": {"x": 1, "y": 2}, "b": None}}
    assert approach.with_actuator(vehicle, "a", {"y": 3, "z": 4}) == {
        "type": "it", "actuators": {"a": {"x": 1, "y": 3, "z": 4}, "b": None}
    }  # fmt: skip
    assert approach.with_actuator(vehicle, "b", {"y": 3})["actuators"]["b"] == {"y": 3}
    assert approach.with_actuator({"type": "it"}, "c", {"y": 3}) == {"type": "it", "actuators": {"c": {"y": 3}}}
    assert vehicle["actuators"] == {"a": {"x": 1, "y": 2}, "b": None}


@pytest.mark.parametrize(
    ("name", "orders", "said"),
    [
        ("turning", {"rudder_deg": -35.0, "seconds": 9.0}, ""),
        ("turning", {"angle_deg": 5.0}, "--angle 5: turning takes --depth, --rudder, --seconds, --speed"),
        ("decay", {"angle_deg": -90.0}, ""),
        ("decay", {"angle_deg": -90.1}, "--angle -90.1: give at most 90 deg"),
        ("zigzag", {"angle_deg": -10.0}, "--angle -10: give a number above 0"),
        ("zigzag", {"rudder_deg": 0.0}, "--rudder 0: give a number other than 0"),
        ("zigzag", {"seconds": -1.0}, "--seconds -1: give a number above 0"),
        ("stop", {"speed_m_s": math.inf}, "--speed inf: give a number above 0"),
        ("bollard", {"depth_m": 5.0}, "--depth 5: bollard takes no option"),
    ],
)
def test_orders_have_their_sign_and_size(name: str, orders: dict[str, float], said: str) -> None:
    if not said:
        check(name, Orders(**orders))
        return
    with pytest.raises(InputError) as caught:
        check(name, Orders(**orders))
    assert str(caught.value) == said
