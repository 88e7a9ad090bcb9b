"""The flow around a vehicle: current, waves, surface and wind at its place, as its model sees them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import drjit as dr

from pelagos import jit
from pelagos.hydro.algebra import Matrix, Vector, add, matvec, minus, scaled, transpose
from pelagos.jit import Array
from pelagos.math.frames import flip_yz
from pelagos.math.so3 import matrix
from pelagos.vehicles.flow import Flow, Seaway, make_flow
from pelagos.vehicles.integrate import Rigid
from pelagos.vehicles.nearby import planes_of
from pelagos.vehicles.seakeeping import speed_along
from pelagos.vehicles.stream import Stream, current_at, stream_at
from pelagos.vehicles.tables import Tables
from pelagos.vehicles.wave_flow import WaveFlow, along_hull, surface_under
from pelagos.vehicles.wetness import Floating

if TYPE_CHECKING:
    from pelagos.vehicles.config import VehicleConfig
    from pelagos.vehicles.model import Model

_AFLOAT = {"hydrostatic", "twin_hull"}  # terms that follow the surface


def flow_around(config: VehicleConfig, model: Model, rigid: Rigid, ocean: Any, t: Array, tables: Tables | None) -> Flow:
    """The water around a vehicle, and the wind above it.

    Args:
        config, model: of the vehicle.
        rigid: its pose and velocity, NED and FRD.
        ocean: see `ocean.ocean.Ocean`; None for still water without end.
        t: time [s].
        tables: what the model reads on the device.
    """
    flow = _water(config, model, rigid, ocean, t, tables)
    if model.feels_planes and tables is not None:
        flow.planes = planes_of(tables.walls, rigid.position, flow.rotation)
    if ocean is not None and model.wetting is not None:
        flow.wet = model.wetting.of(flow)
        if isinstance(model.wetting, Floating):
            flow.far = model.wetting.far(flow)
            if model.sea is not None and flow.seaway is None and tables is not None and tables.hull is not None:
                far = flow.far > 0
                flow.calm = model.sea.still_load(flow.immersion, flow.rotation, tables.hull, far)
        if model.sea is not None:  # what balances the hull as it lies is not there in the air
            balance = scaled(1 - flow.wet.share, model.sea.rest)
            if flow.calm is not None:
                flow.calm = add(flow.calm, balance)
            if flow.seaway is not None:
                flow.seaway.load = add(flow.seaway.load, balance)
    if config.medium == "water" and getattr(ocean, "ballast", None) is not None:
        flow.heaviness = ocean.heaviness(flip_yz(jit.Array3f64(*rigid.position)), t)
    air = getattr(ocean, "air", None)
    if air is not None and air.blows:
        north, west = rigid.position[0], -rigid.position[1]
        back = transpose(flow.rotation)
        flow.air = lambda height: matvec(back, [*flip_yz(ocean.wind(jit.Array3f64(north, west, height), t))])
    return flow


def _water(config: VehicleConfig, model: Model, rigid: Rigid, ocean: Any, t: Array, tables: Tables | None) -> Flow:
    rotation = matrix(rigid.attitude)
    how = config.current_rotation
    if ocean is None:
        return make_flow(rigid.position, rotation, rigid.nu, (0.0, 0.0, 0.0), current_rotation=how)
    if config.medium == "air":
        wind = [*flip_yz(ocean.wind(flip_yz(jit.Array3f64(*rigid.position)), t))]
        return make_flow(rigid.position, rotation, rigid.nu, wind, current_rotation=how)
    current = current_at(ocean, rigid.position, t)
    tide = getattr(ocean, "tide", None)
    if getattr(ocean, "waves", None) is None:
        stream = stream_at(ocean, rigid.position, rotation, config.length_m, t, current)
        return make_flow(
            rigid.position, rotation, rigid.nu, stream.velocity, current_rotation=how,
            elevation=0.0 if tide is None else tide.level(t), acceleration=stream.acceleration,
            turning=stream.turning,
        )  # fmt: skip
    if model.sea is not None:
        stream = stream_at(ocean, rigid.position, rotation, config.length_m, t, current)
        return _seaway(config, model, rigid, rotation, ocean, t, stream, tables)
    waves = _waves(config, ocean, rigid.position, rotation, t, current)
    stream = stream_at(ocean, rigid.position, rotation, config.length_m, t, current, waves.velocity)
    return make_flow(
        rigid.position, rotation, rigid.nu, add(stream.velocity, waves.velocity), current_rotation=how,
        elevation=waves.elevation, acceleration=add(stream.acceleration, waves.acceleration),
        surface=waves.surface, turning=add(stream.turning, waves.turning), turning_rate=waves.turning_rate,
    )  # fmt: skip


def _seaway(
    config: VehicleConfig,
    model: Model,
    rigid: Rigid,
    rotation: Matrix,
    ocean: Any,
    t: Array,
    stream: Stream,
    tables: Tables | None,
) -> Flow:
    """The flow past a hull that floats, and the loads of waves on it."""
    sea = model.sea
    assert sea is not None
    assert tables is not None
    assert tables.hull is not None
    past = over = None
    if sea.ahead is not None:
        over = speed_along(rotation, matvec(rotation, rigid.nu[:3]))
        past = over - speed_along(rotation, stream.velocity)
    waves = sea.waves(ocean, rigid.position, rotation, t, speed=over)
    velocity = sea.to_body(rotation, waves.velocity)
    surface, ahead, starboard = waves.plane()
    flow = make_flow(
        rigid.position, rotation, rigid.nu, add(stream.velocity, matvec(rotation, velocity[:3])),
        current_rotation=config.current_rotation,
        elevation=surface if ocean.tide is None else surface + ocean.tide.level(t),
        acceleration=stream.acceleration, turning=stream.turning, surface=(-dr.atan(starboard), dr.atan(ahead)),
    )  # fmt: skip
    water = sea.to_body(rotation, waves.acceleration)
    load = sea.load(ocean, waves, rigid.position, rotation, water, t, tables.hull, speed=past)
    if sea.diffraction is None:
        through = [*flow.nu_r[:3], *add(rigid.nu[3:], minus(velocity[3:]))]
    else:  # waves that come are scattered as if the hull were held: only its own motion radiates
        through = [*add(flow.nu_r[:3], velocity[:3]), *rigid.nu[3:]]
    flow.seaway = Seaway(load, through, past)
    return flow


def _waves(
    config: VehicleConfig, ocean: Any, position: Vector, rotation: Matrix, t: Array, current: Vector
) -> WaveFlow:
    """The waves at a vehicle; what floats feels the surface under its whole waterplane."""
    afloat = any(getattr(term, "type", "") in _AFLOAT for term in config.terms.values())
    if not afloat:
        return along_hull(ocean, position, rotation, config.length_m, t, current)
    motion = ocean.wave_motion(flip_yz(jit.Array3f64(*position)), t)
    velocity, acceleration = [*flip_yz(motion.velocity)], [*flip_yz(motion.acceleration)]
    elevation, surface = surface_under(
        lambda x, y: ocean.elevation(x, -y, t), position, rotation, config.length_m, config.beam
    )
    still = (0.0, 0.0, 0.0)
    return WaveFlow(velocity, [*acceleration[:2], jit.Float64(0.0)], still, still, elevation, surface)
