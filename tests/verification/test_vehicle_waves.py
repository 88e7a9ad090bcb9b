"""Vehicles in regular waves against linear theory: deep water, k = w^2/g, orbits a e^{-k d} at depth d."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import drjit as dr
import numpy as np
import pytest

import pelagos as pl
from pelagos import jit
from pelagos.math.constants import GRAVITY
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.ocean.hull_waves import Waterplane
from pelagos.vehicles.integrate import Rigid

HEIGHT_M, PERIOD_S = 1.0, 6.0
K = (2 * math.pi / PERIOD_S) ** 2 / 9.81


def ride(vehicle: str, depth_m: float, *, seconds: float = 48.0, heading_deg: float = 0.0) -> dict[str, float]:
    """Amplitudes of surge, heave [m], roll and pitch [rad] at the waves' period, by least squares."""
    sim = pl.Simulation.load(
        {
            "tick_rate_hz": 100,
            "world": {"type": "flat", "depth_m": 200.0},
            "ocean": {"waves": [{"type": "regular", "height_m": HEIGHT_M, "period_s": PERIOD_S, "towards_deg": 0.0}]},
            "agents": {
                "it": {
                    "vehicle": vehicle,
                    "control": "actuators",
                    "start": {"position_m": [0.0, 0.0], "depth_m": depth_m, "heading_deg": heading_deg},
                }
            },
        }
    )
    if depth_m > 0:  # let go with the water's own motion (a crest is overhead), or it keeps sinking past its orbit
        speed = HEIGHT_M / 2 * 2 * math.pi / PERIOD_S * math.exp(-K * depth_m)
        sim.set_state("it", velocity=(speed, 0.0, 0.0))
    t, rows = [], []
    while sim.time_ns < seconds * 1e9:
        sim.run(0.2)
        state = sim.state["it"]
        t.append(sim.time_ns * 1e-9)
        rows.append([state.position[0, 0], state.position[0, 2], state.euler[0, 0], state.euler[0, 1]])
    keep = np.array(t) > seconds - 4 * PERIOD_S
    when, values = np.array(t)[keep], np.array(rows)[keep]
    # the vehicle drifts slowly through the waves: a little freedom in the period of encounter, and a trend
    best = None
    for period in PERIOD_S * np.linspace(0.97, 1.03, 25):
        w = 2 * math.pi / period
        basis = np.stack([np.ones_like(when), when, when**2, np.cos(w * when), np.sin(w * when)], axis=-1)
        found, residual, *_ = np.linalg.lstsq(basis, values, rcond=None)
        if best is None or residual.sum() < best[0]:
            best = residual.sum(), np.hypot(found[3], found[4])
    return dict(zip(("surge", "heave", "roll", "pitch"), best[1], strict=True)) | {"depth": -values[:, 1].mean()}


@pytest.mark.parametrize("depth_m", [6.0, 12.0])
def test_a_neutral_vehicle_moves_with_the_water(depth_m):
    """It displaces its own weight, so the pressure that moves the water moves it: e^{-kd} at its own depth.

    Lift and damping act on what little relative motion there is, and let it drift by some centimetres a second: 5 %.
    """
    found = ride("remus100", depth_m)
    orbit = HEIGHT_M / 2 * math.exp(-K * found["depth"])
    assert found["heave"] == pytest.approx(orbit, rel=0.05)
    assert found["surge"] == pytest.approx(orbit, rel=0.05)


def test_half_a_wave_length_down_it_barely_moves_and_at_periscope_depth_it_does():
    found = ride("remus100", math.pi / K)
    assert found["heave"] < 0.06 * HEIGHT_M / 2  # e^{-pi} = 0.043
    shallow = ride("remus100", 0.05 * 2 * math.pi / K)
    assert shallow["heave"] == pytest.approx(HEIGHT_M / 2 * math.exp(-K * shallow["depth"]), rel=0.08)
    assert shallow["heave"] > 0.45 * HEIGHT_M / 2 > 7 * found["heave"]


@pytest.mark.parametrize("vehicle", ["wamv", "surface_vessel", "otter"])
def test_long_waves_carry_what_floats(vehicle):
    """56 m long waves under hulls of 2 to 5 m: heave goes to the elevation, pitch to the slope ka = 3.2 deg."""
    found = ride(vehicle, 0.0)
    assert found["heave"] == pytest.approx(HEIGHT_M / 2, rel=0.06)
    assert found["pitch"] == pytest.approx(K * HEIGHT_M / 2, rel=0.15)


@pytest.mark.parametrize(("period_s", "low", "high"), [(20.0, 0.9, 1.05), (8.0, 0.0, 0.1)])
def test_a_ship_rides_long_waves_and_bridges_short_ones(period_s: float, low: float, high: float):
    """161 m: waves of four lengths lift it whole, those of 0.6 lengths hardly (their push adds up to little)."""
    start = {"position_m": [0.0, 0.0], "depth_m": 0.0, "speed_mps": 7.7}
    sim = pl.Simulation.load(
        {
            "tick_rate_hz": 20,
            "world": {"type": "flat", "depth_m": 200.0, "size_m": [6000, 6000]},
            "ocean": {"waves": {"type": "regular", "height_m": 4.0, "period_s": period_s, "towards_deg": 180.0}},
            "agents": {"it": {"vehicle": "mariner", "start": start}},
        }
    )
    sim.run(120.0)
    z = []
    for _ in range(80):
        sim.run(0.5)
        z.append(float(sim.state["it"].position[0, 2]))
    assert low * 2.0 <= 0.5 * (max(z) - min(z)) <= high * 2.0


def test_waves_from_abeam_roll():
    found = ride("wamv", 0.0, heading_deg=90.0)
    assert found["roll"] > 100 * found["pitch"]
    # the slope's amplitude; the hull's breadth takes (k b)^2 / 24 = 0.3 % of it, and it rolls in a third of the period
    assert found["roll"] == pytest.approx(K * HEIGHT_M / 2, rel=0.02)


def test_a_tanker_in_a_moderate_sea_goes_as_in_calm_water():
    """Waves much shorter than the hull hardly move it; taken as a point it was carried off at 17 m/s in 150 s."""
    found = {}
    for state in (None, 4):
        scenario = {
            "tick_rate_hz": 20,
            "world": {"type": "flat", "depth_m": 200},
            "ocean": {"waves": [] if state is None else [{"type": "sea_state", "state": state}]},
            "agents": {"it": {"vehicle": "kvlcc2", "control": "actuators"}},
        }
        sim = pl.Simulation.load(scenario)
        sim.run(150.0)
        found[state] = sim.state["it"].velocity[0]
    assert found[None][0] > 2.0
    assert found[4] == pytest.approx(found[None], abs=0.2)


TILTED = {"type": "regular", "height_m": 3.0, "period_s": 14.0, "towards_deg": 200.0}  # 306 m long


def afloat_at(heading_deg: float, vehicle: Any, depth_m: float = 0.0, **ocean: Any) -> tuple[Any, np.ndarray]:
    """The flow around a craft at north 40 m, east -25 m, 3.7 s; and `(3, 3)` NED -> FRD."""
    psi, t = math.radians(heading_deg), jit.Float64(3.7)
    rigid = Rigid(
        [jit.Float64(v) for v in (40.0, -25.0, depth_m)],
        jit.Array4f64(*(jit.Float64(v) for v in (math.cos(psi / 2), 0.0, 0.0, math.sin(psi / 2)))),
        [jit.Float64(v) for v in (1.1, -0.3, 0.2, 0.0, 0.0, 0.0)],
    )
    made = build_ocean(OceanConfig.model_validate({"waves": [TILTED], **ocean}))
    cos, sin = math.cos(psi), math.sin(psi)
    return pl.Vehicle.from_dict(vehicle).flow(rigid, made, t), np.array(
        [[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]]
    )


def number(value: Any) -> float:
    return float(np.array(jit.Float64(value))[0])


def numbers(values: Any) -> np.ndarray:
    """Of one lane, by one kernel."""
    made = [jit.Float64(v) for v in values]
    dr.eval(made)
    return np.array([number(v) for v in made])


@pytest.mark.parametrize("heading_deg", [50.0, -110.0])
@pytest.mark.parametrize("seakeeping", ["slope", "pressure"])
def test_what_floats_lies_in_an_oblique_wave_as_its_slope_does(seakeeping: str, heading_deg: float) -> None:
    """a cos(k s - w t) along s = n cos(200) + e sin(200): elevation, its slope ahead and to starboard, and the water's
    velocity in the body's axes, on a current and a tide. Of 306 m, with 2 m of hull and 0.2 m of draught: kL = 0.04,
    (kL)^2 / 24 = 7e-5, and k T = 4e-3 of the velocity.
    """
    currents = [{"type": "uniform", "speed_mps": 0.6, "towards_deg": 70.0}]
    tide = [{"amplitude_m": 0.8, "period_h": 12.0, "phase_deg": 0.0}]
    otter = {"type": "otter", "seakeeping": seakeeping}
    flow, turn = afloat_at(heading_deg, otter, currents=currents, tide=tide)
    w, towards = 2 * math.pi / 14.0, np.array([math.cos(math.radians(200)), math.sin(math.radians(200)), 0.0])
    k = w * w / GRAVITY
    phase = k * (towards @ [40.0, -25.0, 0.0]) - w * 3.7
    assert number(flow.immersion) == pytest.approx(0.8 + 1.5 * math.cos(phase), abs=1e-3)
    ahead, starboard, _ = -1.5 * k * math.sin(phase) * (turn @ towards)
    roll, pitch = numbers(flow.surface)
    assert pitch == pytest.approx(math.atan(ahead), rel=1e-3)
    assert roll == pytest.approx(-math.atan(starboard), rel=1e-3)
    current = 0.6 * np.array([math.cos(math.radians(70)), math.sin(math.radians(70)), 0.0])
    water = current + 1.5 * w * (math.cos(phase) * towards - math.sin(phase) * np.array([0.0, 0.0, 1.0]))
    through = np.array([1.1, -0.3, 0.2]) - turn @ water
    assert numbers(flow.nu_r[:3]) == pytest.approx(through, abs=5e-3)
    if (
        seakeeping == "pressure"
    ):  # as a sheet the water nods with its slope and turns by the change of its sideways motion
        across = turn @ towards
        nods = 1.5 * k * w * math.cos(phase) * np.array([-across[1], across[0], 0.0])
        nods[2] = -1.5 * k * w * math.sin(phase) * across[0] * across[1]
        assert flow.seaway is not None
        assert numbers(flow.seaway.velocity[3:]) == pytest.approx(-nods, abs=1e-2 * np.abs(nods).max())
    if seakeeping == "slope":  # a pressed hull has the water's acceleration in its load
        assert flow.water_acceleration is not None
        rate = 1.5 * w * w * math.sin(phase) * (turn @ towards)
        assert numbers(flow.water_acceleration[:3]) == pytest.approx([*rate[:2], 0.0], abs=0.05 * abs(rate).max())


@pytest.mark.parametrize("heading_deg", [50.0, -110.0])
def test_wind_blows_over_a_craft_in_its_own_axes(heading_deg: float) -> None:
    """7 m/s from 310 deg, 10 m up; gusts are those of the moment, at the height that is asked for."""
    flow, turn = afloat_at(heading_deg, {"type": "otter"}, waves=[], wind={"speed_mps": 7.0, "from_deg": -50.0})
    found = numbers(flow.air(jit.Float64(10.0)))
    expected = turn @ (7.0 * np.array([math.cos(math.radians(130)), math.sin(math.radians(130)), 0.0]))
    assert found == pytest.approx(expected, abs=1e-9)
    gusty = {"speed_mps": 7.0, "from_deg": -50.0, "gusts": 1.0}
    flow, _ = afloat_at(heading_deg, {"type": "otter"}, waves=[], wind=gusty)
    place = jit.Array3f64(*(jit.Float64(v) for v in (0.0, 0.0, 3.0)))
    north, west, up = build_ocean(OceanConfig.model_validate({"wind": gusty})).wind(place, jit.Float64(3.7))
    expected = turn @ numbers([north, -west, -up])
    assert numbers(flow.air(jit.Float64(3.0))) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize(("heading_deg", "depth_m"), [(50.0, -30.0), (-110.0, -4.0)])
def test_what_flies_is_carried_by_the_wind_at_its_height(heading_deg: float, depth_m: float) -> None:
    """ISO 19901-1, A.7: 8 m/s at 10 m grow by 5.73 % sqrt(1 + 0.15 * 8) with the logarithm of height over 10 m."""
    wind = {"speed_mps": 8.0, "from_deg": -50.0}
    flow, turn = afloat_at(heading_deg, {"type": "quadrotor"}, waves=[], wind=wind, depth_m=depth_m)
    speed = 8.0 * (1 + 5.73e-2 * math.sqrt(1 + 0.15 * 8.0) * math.log(-depth_m / 10.0))
    air = turn @ (speed * np.array([math.cos(math.radians(130)), math.sin(math.radians(130)), 0.0]))
    assert numbers(flow.nu_r[:3]) == pytest.approx(np.array([1.1, -0.3, 0.2]) - air, abs=1e-6)


@pytest.mark.parametrize("vehicle", ["otter", "remus100"])
def test_a_tide_without_waves_lifts_the_surface_over_whatever_is_at_its_place(vehicle: str) -> None:
    tide = [{"amplitude_m": 0.8, "period_h": 12.0, "phase_deg": 180.0}]
    flow, _ = afloat_at(50.0, {"type": vehicle}, waves=[], tide=tide)
    assert number(flow.immersion) == pytest.approx(-0.8, abs=1e-6)


def test_a_vehicle_is_as_heavy_as_the_water_at_its_place() -> None:
    """Salinity that grows by 0.05 a metre westwards: 25 m west of the origin, where it is ballasted, by 1.25, and with
    that density by 0.77 kg/m^3 each; hulls that are made for no waves feel it too.
    """
    salt = [{"type": "uniform", "value": 30.0}, {"type": "gradient", "per_m": 0.05, "towards_deg": -90.0}]
    flow, _ = afloat_at(50.0, {"type": "otter"}, waves=[], temperature_c=10.0, salinity=salt)
    assert number(flow.heaviness) == pytest.approx(1 + 0.77 * 1.25 / 1023.1, abs=2e-5)


@pytest.mark.parametrize("heading_deg", [50.0, -110.0])
def test_what_current_and_waves_turn_along_a_hull_adds_up(heading_deg: float) -> None:
    """In the core of a vortex of Lamb and Oseen water turns by 1.2564 / (1 - exp(-1.2564)) = 1.7564 times V / R to
    port: to it a hull at rest turns to starboard. Waves of 39 m turn the line of water along it in pitch and yaw.
    """
    eddy = [{"type": "vortex", "radius_m": 60.0, "speed_mps": 2.0, "center_m": [40.0, 25.0]}]
    short = [{"type": "regular", "height_m": 1.0, "period_s": 5.0, "towards_deg": 200.0}]
    both, still, alone = (
        numbers(afloat_at(heading_deg, {"type": "remus100"}, waves=w, currents=c)[0].nu_r[3:])
        for w, c in ((short, eddy), ([], eddy), (short, []))
    )
    assert still == pytest.approx([0, 0, 1.7564 * 2.0 / 60.0], rel=2e-3, abs=1e-6)
    assert both - still == pytest.approx(alone, abs=1e-9)
    assert (np.abs(alone[1:]) > 1e-3).all()


def test_speed_ahead_through_the_water_is_that_of_both() -> None:
    """A ship of strips at 1.1 m/s, heading -125 deg, on a current of 0.6 m/s towards 70 deg: less its part ahead."""
    currents = [{"type": "uniform", "speed_mps": 0.6, "towards_deg": 70.0}]
    flow, _ = afloat_at(-125.0, {"type": "mariner", "variant": "strips"}, currents=currents)
    expected = 1.1 - 0.6 * math.cos(math.radians(70.0 + 125.0))
    assert number(flow.seaway.speed) == pytest.approx(expected, abs=1e-9)


HULL = {"length_m": 6.0, "beam_m": 2.4, "freeboard_m": 0.8}


def hulls(*parts: dict[str, Any], **afloat: Any) -> Any:
    """Seakeeping of boxes that weigh 7200 kg together, in water of 1000 kg/m^3."""
    mass = 7200.0
    return pl.Vehicle.from_dict({
        "type": "custom", "density_kg_m3": 1000.0, "length_m": 6.0, "beam_m": 2.4, "height_m": 1.3,
        "mass": {"type": "explicit", "mass_kg": mass, "inertia_kg_m2": [0.6 * mass, 3 * mass, 3 * mass]},
        "added_mass": {"type": "none"},
        "terms": {"hydrostatics": {"type": "hydrostatic", "heave_n_m": 1.4e5, "roll_n_m": 3e4, "pitch_n_m": 4e5}},
        "modes": {"actuators": {"type": "actuators"}}, "default_mode": "actuators",
        "afloat": {"hulls": list(parts), **afloat},
    }).model.sea  # fmt: skip


@pytest.mark.parametrize(
    ("parts", "plane"),
    [
        ([HULL], Waterplane(6.0, 1.2, 0.5, False)),
        ([HULL | {"position_x_m": -0.7}], Waterplane(7.4, 1.2, 0.5, False)),
        ([HULL, HULL | {"beam_m": 1.6, "length_m": 5.0}], Waterplane(6.0, 1.2, 7.2 / 22.4, False)),
        ([HULL | {"position_y_m": 1.9, "mirror": True}], Waterplane(6.0, 1.9, 0.25, True)),
        (
            [HULL, HULL | {"position_y_m": -1.9, "length_m": 3.0, "position_x_m": 2.0}],
            Waterplane(7.0, 1.9, 1 / 3, True),
        ),
    ],
)
def test_the_box_of_the_wet_part_holds_all_hulls(parts: list[dict[str, Any]], plane: Waterplane) -> None:
    """From the draught at which 7.2 m^3 are displaced, to the outermost centre line or half the beam, and both ends."""
    found = hulls(*parts).plane
    assert found.twin == plane.twin
    assert (found.length, found.sides, found.draught) == pytest.approx((plane.length, plane.sides, plane.draught))


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("twin", [False, True])
def test_the_surface_across_a_hull_is_that_under_its_breadth(twin: bool, side: float) -> None:
    """A wave from abeam, a cos(k y), to one side or the other: under a box of half the beam b the mean is a sin(x)/x,
    x = k b, and the least straight line's slope 3 a (sin x - x cos x) / (b x^2); under two centre lines at b, a cos(x)
    and a sin(x) / b. Three nodes of Gauss are off by x^6 / 31500 and x^4 / 700 of these.
    """
    sea = hulls(HULL | ({"position_y_m": 1.9, "mirror": True} if twin else {}))
    wave = {"type": "regular", "height_m": 0.4, "period_s": 2.2, "towards_deg": 90.0 * side, "phase_deg": 40.0}
    made = build_ocean(OceanConfig.model_validate({"waves": [wave]}))
    zero, one = jit.Float64(0.0), jit.Float64(1.0)
    level = [[one, zero, zero], [zero, one, zero], [zero, zero, one]]
    mean, ahead, starboard = (number(v) for v in sea.waves(made, [zero] * 3, level, zero).plane())
    b = 1.9 if twin else 1.2
    k, p, a = (2 * math.pi / 2.2) ** 2 / GRAVITY, math.radians(40.0), 0.2
    x = k * b
    middle, slope = (math.cos(x), math.sin(x) / b) if twin else (
        math.sin(x) / x, 3 * (math.sin(x) - x * math.cos(x)) / (b * x * x)
    )  # fmt: skip
    assert mean == pytest.approx(a * math.cos(p) * middle, rel=2e-3)
    assert starboard == pytest.approx(-side * a * math.sin(p) * slope, rel=4e-3)
    assert ahead == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("deeper", [0.06, -0.09])
@pytest.mark.parametrize(
    ("parts", "area"),
    [
        ([HULL], (14.4, 0.0, 0.0)),
        ([HULL, HULL | {"position_y_m": -1.9, "length_m": 3.0, "position_x_m": 2.0}], (21.6, -13.68, 14.4)),
    ],
)
def test_the_water_of_its_place_and_tide_carries_a_hull(
    parts: list[dict[str, Any]], area: tuple[float, float, float], deeper: float
) -> None:
    """-g A (rho (T + z + tide) - 1000 T) and its moments by the first moments of the area: boxes draw T in water of
    1000 kg/m^3, and 7 m north and 4 m west of the origin it is 1026; of waves they have none to speak of, 1e-6 m.
    """
    sea = hulls(*parts)
    wave = {"type": "regular", "height_m": 2e-6, "period_s": 8.0}
    waves = build_ocean(OceanConfig.model_validate({"waves": [wave]}))
    ocean = SimpleNamespace(
        density=lambda place, t: 1000 + 2 * place[0] + 3 * place[1],
        tide=SimpleNamespace(level=lambda t: 0.8 + 0 * t), sea=waves.sea,
    )  # fmt: skip
    zero, one = jit.Float64(0.0), jit.Float64(1.0)
    level = [[one, zero, zero], [zero, one, zero], [zero, zero, one]]
    position = [jit.Float64(v) for v in (7.0, -4.0, -0.8 + deeper)]
    found = sea.load(ocean, sea.waves(ocean, position, level, zero), position, level, [zero] * 6, zero, sea.table())
    whole, y, x = area
    draught = 7.2 / whole
    push = -sea.gravity * (1026 * (draught + deeper) - 1000 * draught)
    assert numbers(found) == pytest.approx([0, 0, push * whole, push * y, -push * x, 0], abs=2.0)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_two_waves_from_abeam_push_and_turn_by_their_envelope_at_the_hull(side: float) -> None:
    """Where D is the same at all frequencies, Newman's force is rho D (a^2 + b^2 + 2 a b cos(p - q)) with the phases p
    and q at the hull's place; from port waves push to starboard and turn the bow by the yaw that is given, from
    starboard the other way.
    """
    push = [[[7.0, 0.0, 0.0], [0.0, 12.0, -5.0], [-9.0, 0.0, 0.0]]] * 2
    drift = {"omega_radps": [0.5, 2.0], "heading_deg": [0.0, 90.0, 180.0], "force": push}
    zero, t = jit.Float64(0.0), 4.3
    sizes, periods, phases = np.array([0.3, 0.2]), np.array([5.0, 5.9]), np.array([20.0, -65.0])
    parts = [{"type": "regular", "height_m": 2 * a, "period_s": p, "towards_deg": 30.0 + 90.0 * side, "phase_deg": f}
             for a, p, f in zip(sizes, periods, phases, strict=True)]  # fmt: skip
    waves = build_ocean(OceanConfig.model_validate({"waves": parts}))
    ocean = SimpleNamespace(density=lambda place, t: 1000.0 + 0 * place[0], tide=None, sea=waves.sea)
    heading, one = math.radians(30.0), jit.Float64(1.0)
    c, s = math.cos(heading) * one, math.sin(heading) * one
    level, position = [[c, -s, zero], [s, c, zero], [zero, zero, one]], [37.0 * one, -22.0 * one, zero]
    loads = []
    for sea in (hulls(HULL, drift=drift), hulls(HULL)):
        met = sea.waves(ocean, position, level, t * one)
        load = sea.load(ocean, met, position, level, [zero] * 6, t * one, sea.table())
        loads.append(numbers(load))
    w, towards = 2 * math.pi / periods, math.radians(30.0 + 90.0 * side)
    along = 37.0 * math.cos(towards) - 22.0 * math.sin(towards)
    p, q = w * w / GRAVITY * along - w * t + np.radians(phases)
    envelope = np.sum(sizes**2) + 2 * sizes.prod() * math.cos(p - q)
    expected = 1000.0 * envelope * side * np.array([0.0, 12.0, 0.0, 0.0, 0.0, -5.0])
    assert 0.02 < envelope < 0.2
    assert loads[0] - loads[1] == pytest.approx(expected, abs=0.5)


def test_a_wave_loads_a_ship_where_it_is_as_it_did_another_when_it_was_there() -> None:
    """A regular wave at a place s along its way is that of the origin s k / w earlier: pressure, scattering."""
    w, towards, psi = 2 * math.pi / 9.0, math.radians(200.0), math.radians(50.0)
    late = w / GRAVITY * (37.0 * math.cos(towards) - 22.0 * math.sin(towards))
    rigid = Rigid(
        [jit.Float64(v) for v in ([37.0, 0.0], [-22.0, 0.0], [0.3, 0.3])],
        jit.Array4f64(*(jit.Float64([v, v]) for v in (math.cos(psi / 2), 0.0, 0.0, math.sin(psi / 2)))),
        [jit.Float64([v, v]) for v in (3.1, -0.3, 0.2, 0.01, 0.02, -0.01)],
    )
    wave = {"type": "regular", "height_m": 2.0, "period_s": 9.0, "towards_deg": 200.0, "phase_deg": 25.0}
    ocean = build_ocean(OceanConfig.model_validate({"waves": [wave]}))
    ship = pl.Vehicle.from_dict({"type": "mariner", "variant": "strips"})
    flow = ship.flow(rigid, ocean, jit.Float64([4.0, 4.0 - late]))
    assert flow.seaway is not None
    dr.eval(flow.seaway.load)
    for load in flow.seaway.load:
        here, there = np.array(load)
        assert here == pytest.approx(there, rel=1e-6)
        assert abs(here) > 1e3
