"""The ping of every sonar that gives intensities by range: from rays to echoes by beam sector and range bin."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.acoustics.echo_strips import Strips
from pelagos.acoustics.echo_walk import Bins, Walkers, walk
from pelagos.acoustics.pulse import point_spread, range_coupling, range_resolution
from pelagos.acoustics.spreading import to_db
from pelagos.errors import InputError, ValidityWarning
from pelagos.jit import Array
from pelagos.math.constants import NOMINAL_SOUND_SPEED
from pelagos.math.so3 import multiply, rotate
from pelagos.sensors.mount import sensor_angular_velocity, sensor_velocity
from pelagos.sensors.noise import BatchPath
from pelagos.sensors.schedule import period_ticks
from pelagos.sensors.sonar.ping.aperture import Facing
from pelagos.sensors.sonar.ping.arrivals import arrivals
from pelagos.sensors.sonar.ping.cells import Constants
from pelagos.sensors.sonar.ping.clumps import crowd
from pelagos.sensors.sonar.ping.echo_field import apply_gain, calibrated_echoes, echoes, energies
from pelagos.sensors.sonar.ping.elements import element_tables, ping_by_elements, steering_speed, without_noise
from pelagos.sensors.sonar.ping.emitter import Apertures, Emitter
from pelagos.sensors.sonar.ping.fan import Fan, FanHits, Trace, cast_fan
from pelagos.sensors.sonar.ping.interference import Neighbours, silence_blocked
from pelagos.sensors.sonar.ping.layout import Layout
from pelagos.sensors.sonar.ping.levels import Din, Moment
from pelagos.sensors.sonar.ping.listener import Hearing, Listener
from pelagos.sensors.sonar.ping.medium import Medium
from pelagos.sensors.sonar.ping.multipath import Mirrors, bounced_echoes
from pelagos.sensors.sonar.ping.painted_noise import streak_rows
from pelagos.sensors.sonar.ping.ping_spec import Bounces, PingSpec, behind_filter, noise_power
from pelagos.sensors.sonar.ping.receiver import mean_levels, receive, trace_levels
from pelagos.sensors.sonar.ping.sounder import Ping, Sounder, Waters
from pelagos.sensors.sonar.ping.target_echoes import (
    Grid,
    coherent_echoes,
    excluded_share,
    with_small_energies,
    with_small_things,
)
from pelagos.sensors.sonar.ping.target_sighting import Sighting, sight_targets
from pelagos.sensors.sonar.ping.targets import Band, Targets, is_smooth, targets
from pelagos.sensors.sonar.ping.vehicle_noise import Bystanders, noise_by_beam
from pelagos.sensors.sonar.ping.volume_echo import TRACER, Haze, OpenWater, probes

if TYPE_CHECKING:
    from pelagos.sensors.sensor import Kinematics, SensorContext

_UNNOTICED_DB: Final = 20.0  # below the noise: what arrives as faint is not computed
_FINEST: Final = 4.0  # bins in one resolution of the pulse beyond which a finer division says nothing


@jit.struct
class Traces:
    """Remainder of a ping, from which its truth is computed when somebody looks at it: a Dr.Jit struct.

    Attributes:
        strips: of the direct echoes, and of those by other ways.
        medium: see `Lanes`.
        haze: what the water sends back; None: nothing.
        sighting: of things that rays may miss; None: there are none.
        smooth: whether any of them has a coherent echo.
    """

    strips: list[Strips]
    medium: Medium
    haze: Haze | None
    sighting: Sighting | None = None
    smooth: bool = False


class Pinger:
    """Parts that a sonar of this kind keeps from ping to ping; none of them changes.

    Args:
        spec: pulse, bins, levels.
        context: see `SensorContext`.
        rays: the ray pattern.
        layout: beams.
        angle: for heads that turn, see `Emitter`.
    """

    def __init__(
        self,
        spec: PingSpec,
        context: SensorContext,
        rays: dict[str, NDArray[Any]],
        layout: Layout,
        angle: Callable[[NDArray[np.int64]], NDArray[np.float64]] | None = None,
    ) -> None:
        self._spec = spec
        self._layout = layout
        self._sounder = Sounder(spec.mounting, context, rays, waters(spec))
        resolution = range_resolution(NOMINAL_SOUND_SPEED, spec.bandwidth_hz)
        if spec.bin_width_m < resolution / _FINEST:
            message = f"{context.path}: bins of {spec.bin_width_m:.3g} m are finer than the pulse resolves, " + (
                f"{resolution:.3g} m at a bandwidth of {spec.bandwidth_hz:g} Hz"
            )
            warnings.warn(message, ValidityWarning, stacklevel=3)
        pulse = point_spread(spec.bin_width_m, resolution, pulse=spec.pulse)
        steering = np.ones((layout.beams, 1), np.float32) if layout.steering is None else layout.steering
        self._walk = walk(rays["beam"], layout.beams)
        noise = noise_power(spec, layout.horizontal_width, layout.vertical_width)
        self._constants = Constants(
            jit.Float(steering.ravel()),
            jit.Float(pulse),
            jit.Float(noise),
            jit.UInt32(spec.roughness_seed),
            jit.UInt32(self._walk.order),
            jit.Float(layout.sector * spec.bin_width_m),
            jit.Float(layout.heard_parts * (spec.equivalent_m / spec.bin_width_m)),
            layout.aperture.facing(),
            jit.Float(boost(spec, layout, pulse)),
            element_tables(layout),
        )
        jit.align(self._constants)
        self._scene, self._materials = context.scene, context.world.palette
        self._generation, self._smooth = -1, False
        self._things: Targets | None = None
        self._grid = Grid(
            layout.beams, Bins(spec.bins, spec.range_min_m, spec.bin_width_m), resolution, spec.pulse,
            layout.sector * spec.bin_width_m,
        )  # fmt: skip
        self._hearing = hearing(spec, layout, rays)
        self._own = emitter(spec, context, rays, layout, angle)
        self._neighbours = context.neighbours
        self._hears = sources_heard(spec, context.path, self._neighbours, self._own)
        self._bystanders = Bystanders(
            spec, self._own, self._neighbours, context.ocean, behind_filter=behind_filter(spec), noise=noise
        )
        if self._bystanders.some and layout.elements is not None:
            without = "elements: false and no errors of channels, or vehicle_noise: none"
            raise InputError(f"{context.path}: elements hear no noise of vehicles: give {without}")
        hazy = spec.volume_scattering_db is not None or TRACER in context.ocean.tracers
        if spec.volume_scatterers is not None and not hazy:
            message = "'volume_scatterers_per_m3' changes nothing without 'volume_scattering_db', or the ocean's tracer"
            warnings.warn(f"{context.path}: {message}", ValidityWarning, stacklevel=3)
        self._water = OpenWater(probes(rays, layout.beams), context.ocean, crowd(spec, layout)) if hazy else None
        self._recorded = self._sounder.compile(self._kernel)
        self._mean = jit.freeze(self._truth)

    def ping(
        self, motion: Kinematics, turn: Array | None = None
    ) -> tuple[NDArray[np.float32], Callable[[], NDArray[np.float32]], dict[str, NDArray[Any]]]:
        """Data `(m, beams, bins)`, a function that computes the truth likewise, and extras by name.

        `turn` is a rotation of the sensor frame by lane, `Array4f64`, for heads that turn.
        """
        spec = self._spec
        (data, *rest), traces = self._recorded(motion, self._constants, self._besides(motion, turn))
        shape = (dr.width(motion.position), self._layout.beams, spec.bins)

        def truth() -> NDArray[np.float32]:
            return np.asarray(self._mean(traces, motion, self._constants)).reshape(shape)

        extras: dict[str, NDArray[Any]] = {}
        if spec.iq:
            real, imaginary = np.array(rest.pop(0)), np.array(rest.pop(0))
            extras["iq"] = (real + 1j * imaginary).astype(np.complex64).reshape(shape)
        if spec.labels:
            extras["label"] = np.array(rest.pop(0)).astype(np.uint8).reshape(shape)
            extras["instance"] = np.array(rest.pop(0)).reshape(shape)
        if self._layout.raw and self._layout.elements is not None:
            pair = np.array(rest.pop(0)).reshape(shape[0], self._layout.elements.count, spec.bins, 2)
            extras["elements"] = pair.view(np.complex64)[..., 0]
            extras["steering_speed"] = np.array(rest.pop(0))
        return np.asarray(data).reshape(shape), truth, extras

    def explain(self, motion: Kinematics, turn: Array | None = None) -> list[tuple[str, NDArray[Any], str]]:
        """One ping, not frozen, with its intermediate arrays: (name, values, unit)."""
        return self._sounder.trace(self._kernel, motion, self._constants, self._besides(motion, turn))

    def _besides(self, motion: Kinematics, turn: Array | None) -> dict[str, Any]:
        """Arguments that only some pings are called with."""
        found: dict[str, Any] = {}
        if turn is not None:
            found["turn"] = turn
        things = self._targets()
        if things is not None:
            found["targets"] = things
        if self._water is not None:
            found["water"] = self._water
        if self._hears and self._neighbours is not None:
            heard = self._neighbours.heard(self._own, self._hears, motion, others=isinstance(self._spec.hears, str))
            if heard is not None:
                found["heard"] = heard
        if self._spec.disturber is not None:
            found["disturber"] = self._own.hears_from(self._spec.disturber.direction, motion)
        if self._bystanders.some:
            din = self._bystanders.heard(motion)
            if din is not None:
                found["vehicles"] = din
        return found

    def _targets(self) -> Targets | None:
        """Targets that rays may miss; looked for anew when other things move.

        Sonars that resolve the lattice of roughness have rays enough, whose phases must go on from ping to ping.
        """
        if self._layout.facet is not None:
            return None
        scene = self._scene
        if self._generation != scene.generation:
            self._generation = scene.generation
            spec, hearing = self._spec, self._hearing
            band = Band(spec.frequency_hz, spec.bandwidth_hz, hearing.rays_per_sr, spec.range_max_m)
            self._things = targets(scene, self._materials, band)
            self._smooth = self._things is not None and is_smooth(self._things)
        return self._things

    def _kernel(
        self, ping: Ping, constants: Constants, besides: dict[str, Any], *, trace: Trace = None
    ) -> tuple[list[Array], Traces]:
        caster, lanes, fan, surfaces, motion = ping.caster, ping.lanes, ping.fan, ping.surfaces, ping.motion
        spec, layout = self._spec, self._layout
        velocity = rotate(lanes.attitude, sensor_velocity(motion, spec.mounting))
        spin = sensor_angular_velocity(motion, spec.mounting)
        if "turn" in besides:
            lanes = replace(lanes, attitude=multiply(lanes.attitude, besides["turn"]))
        far = spec.range_max_m + spec.longest_strip_m
        assumed = spec.sound_speed_mps
        array = assumed if layout.aperture.steered else None
        view = cast_fan(caster, fan, lanes, surfaces, max_range=far, assumed_speed=array)
        patches = [calibrated_echoes(spec, layout, view, fan, lanes, surfaces, velocity, trace)]
        if spec.bounces is not None:
            ghosts = bounced_echoes(
                caster, view, fan, lanes, surfaces, mirrors(spec, layout, spec.bounces, constants.facing)
            )
            patches += [apply_gain(spec, layout, g, view, lanes) for g in ghosts]
        pings = dr.width(lanes.position)
        walkers = self._walkers(constants.order, pings)
        sighting = None
        if "targets" in besides:
            things = besides["targets"]
            sighting = sight_targets(
                caster, things, Listener(lanes, constants.facing, self._hearing, velocity), surfaces
            )
            small, dulled = excluded_share(things, sighting, view.hits.instance, view.lane)
            patches[0].valid &= ~small
            patches[0].energy *= dulled
        field, tags, strips = echoes(spec, layout, patches, walkers, lanes, constants.seed)
        coherent = None
        if sighting is not None:
            dr.eval(field, tags)
            with_small_things(sighting, self._grid, lanes, constants.boost, field, tags, besides["targets"].instance)
            if self._smooth:
                coherent = coherent_echoes(
                    sighting, self._grid, layout.aperture, constants.facing, pings, energies=False
                )
        water, noisy = besides.get("water"), besides.get("vehicles")
        seen = None if water is None else water.seen(spec, layout, view, lanes, constants.facing, motion.t_ns)
        if "heard" in besides:
            coming = silence_blocked(caster, besides["heard"], lanes)
            others = arrivals(coming, lanes, self._grid.bins, beams=layout.beams, bandwidth_hz=spec.bandwidth_hz)
            coherent = others if coherent is None else coherent + others
        vehicles = None if noisy is None else noise_by_beam(caster, noisy, lanes, layout.beams)
        din = Din(coherent, seen, self._streaks(view, fan, pings), vehicles, besides.get("disturber"))
        moment = Moment(lanes, spin, motion.t_ns, ping.key)
        signals: list[Array] = []
        heard, full = constants, spec
        if layout.elements is not None:
            things = (sighting, self._grid) if sighting is not None and self._smooth else None
            elements, noise, field = ping_by_elements(spec, layout, constants, field, moment, seen, things)
            signals = [elements, steering_speed(spec, lanes.medium)] if layout.raw else []
            full, heard, din = without_noise(spec, constants, din, noise)
        out = [*receive(full, layout, heard, field, tags, moment, din), *signals]
        if trace is not None:
            trace_levels(spec, layout, constants, energies(strips, walkers), out[0], moment, din, trace=trace)
        return out, Traces(strips, lanes.medium, seen, sighting, self._smooth)

    def _truth(self, traces: Traces, motion: Kinematics, constants: Constants) -> Array:
        spin = sensor_angular_velocity(motion, self._spec.mounting)
        total = energies(traces.strips, self._walkers(constants.order, dr.width(motion.position)))
        coherent = None
        if traces.sighting is not None:
            dr.eval(total)
            with_small_energies(traces.sighting, self._grid, traces.medium.absorption, constants.boost, total)
            if traces.smooth:
                coherent = coherent_echoes(
                    traces.sighting, self._grid, self._layout.aperture, constants.facing, dr.width(motion.position),
                    energies=True,
                )  # fmt: skip
        din = Din(coherent=coherent, haze=traces.haze)
        return mean_levels(self._spec, self._layout, constants, total, traces.medium, spin, din)

    def _walkers(self, order: Array, pings: int) -> Walkers:
        spec = self._spec
        return Walkers(self._walk, order, pings, Bins(spec.bins, spec.range_min_m, spec.bin_width_m))

    def _streaks(self, view: FanHits, fan: Fan, pings: int) -> Array | None:
        noise, beams = self._spec.display.painting, self._layout.beams
        if noise is None or noise.azimuth_streaks == "none":
            return None
        row = view.lane * beams + dr.gather(jit.UInt32, fan.beam, view.ray)
        found = streak_rows(view.sine, view.hits.valid, row, pings * beams)
        dr.eval(found)
        return found


def hearing(spec: PingSpec, layout: Layout, rays: dict[str, NDArray[Any]]) -> Hearing:
    """Reception of targets."""
    solid_angle = float(np.mean((rays["upper"] - rays["lower"]) * rays["across"]))
    return Hearing(
        aperture=layout.aperture,
        beams=layout.beams,
        rays_per_sr=1.0 / solid_angle,
        wave_cycles=2.0 * spec.frequency_hz,
        wavelength=NOMINAL_SOUND_SPEED / spec.frequency_hz,
        reach=spec.range_max_m,
        coupling_s=range_coupling(spec.frequency_hz, spec.bandwidth_hz, spec.pulse_s, spec.pulse),
        doppler=spec.doppler,
        assumed_speed=spec.sound_speed_mps,
    )


def boost(spec: PingSpec, layout: Layout, pulse: NDArray[np.float32]) -> NDArray[np.float32]:
    """See `Constants`: one where sectors and bins are finer than what beams and pulse resolve."""
    middle = (
        np.ones(layout.beams) if layout.steering is None else layout.steering[:, layout.steering.shape[1] // 2] ** 2
    )
    peak = float(pulse[len(pulse) // 2]) ** 2 * spec.equivalent_m / spec.bin_width_m
    return np.asarray(1.0 / (middle * layout.heard_parts * peak), dtype=np.float32)


def emitter(
    spec: PingSpec, context: SensorContext, rays: dict[str, NDArray[Any]], layout: Layout,
    angle: Callable[[NDArray[np.int64]], NDArray[np.float64]] | None,
) -> Emitter:  # fmt: skip
    """A sonar as others hear it."""
    noise = noise_power(spec, layout.horizontal_width, layout.vertical_width)
    apertures = Apertures.of_fan(rays, layout.beams, layout.horizontal_width, layout.vertical_width)
    if layout.aperture.steered:
        apertures = Apertures.of_array(layout.aperture)
    return Emitter(
        context.path,
        spec.mounting,
        apertures,
        spec.frequency_hz,
        spec.bandwidth_hz,
        spec.pulse_s,
        spec.source_level_db,
        period_ticks(spec.rate_hz, context.dt_ns, where=context.path) * context.dt_ns,
        angle,
        spec.pulse,
        spec.source_level_db + float(to_db(noise)) - _UNNOTICED_DB,
    )


def waters(spec: PingSpec) -> Waters:
    """Water and surfaces that a ping's rays meet."""
    return Waters(
        frequency_hz=spec.frequency_hz,
        ph=spec.ph,
        wind_speed=spec.wind_speed_mps,
        texture_db=spec.texture_db,
        refraction=spec.refraction,
        reach=spec.range_max_m + spec.longest_strip_m,
        sea_surface=spec.sea_surface,
    )


def sources_heard(spec: PingSpec, path: str, neighbours: Neighbours | None, own: Emitter) -> list[str]:
    """The paths of the sonars that disturb this one; and let others hear it."""
    if neighbours is None:
        return []
    if spec.heard:
        neighbours.add(own)
    members = path.members if isinstance(path, BatchPath) else (path,)
    wanted = {name for member in members for name in neighbours.chosen(spec.hears, member)}
    return [name for name in (neighbours.paths if isinstance(spec.hears, str) else spec.hears) if name in wanted]


def mirrors(spec: PingSpec, layout: Layout, bounces: Bounces, facing: Facing) -> Mirrors:
    """Boundaries at which sound bounces."""
    return Mirrors(
        bottom=bounces.bottom,
        order=bounces.order,
        max_range=spec.range_max_m + spec.longest_strip_m,
        longest=spec.longest_strip_m,
        surface_loss_db=bounces.surface_loss_db,
        bottom_loss_db=bounces.bottom_loss_db,
        aperture=layout.aperture,
        facing=facing,
    )
