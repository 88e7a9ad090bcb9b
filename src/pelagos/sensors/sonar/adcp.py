"""Acoustic Doppler current profiler: the water's velocity in cells along four slanted beams."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, ClassVar, Final, Literal, Self

import drjit as dr
import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from pelagos import jit
from pelagos.acoustics.doppler import heard_water, janus_beams, velocity_from_beams
from pelagos.config.rate import Rate
from pelagos.jit import Array
from pelagos.math.so3 import rotate, rotate_back
from pelagos.sensors.mount import sensor_velocity
from pelagos.sensors.noise import Key, normals64_from
from pelagos.sensors.recorded import Program, Results
from pelagos.sensors.schedule import SLOWEST, farthest_heard
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext
from pelagos.sensors.sonar.keys.echo_keys import EchoesConfig, echo_spec, warn_of_idle
from pelagos.sensors.sonar.keys.ping_keys import mounting
from pelagos.sensors.sonar.ping.beam_echoes import BeamEchoes
from pelagos.sensors.sonar.ping.fan import Lanes, Trace
from pelagos.sensors.sonar.ping.pulse_pairs import Pairs
from pelagos.sensors.sonar.ping.sea_state import wind_for
from pelagos.sensors.sonar.ping.sounder import Ping, Sounder, Waters

if TYPE_CHECKING:
    from pelagos.ocean.ocean import Ocean


_OF_ECHOES: Final = ("frequency_hz", "beamwidth_deg", "ph", "wind_speed_mps")
_FASTEST: Final = 1600.0  # sound speed [m/s] that no sea exceeds
_CLEAR_DB: Final = -75.0  # Sv [dB re 1/m] of ordinary coastal water; assumed


class AdcpConfig(EchoesConfig):
    """A four-beam current profiler that looks along -z of its frame (roll 180 deg to look up). 600 kHz class."""

    type: Literal["adcp"] = "adcp"
    rate_hz: Rate = 1.0
    """Profiles per second [Hz]."""
    cells: int = Field(default=30, ge=1, le=512)
    """Depth cells."""
    cell_m: float = Field(default=1.0, gt=0)
    """Height of a cell [m]."""
    blank_m: float = Field(default=0.5, ge=0)
    """Distance to the near edge of the first cell, along the vertical [m]."""
    beam_tilt_deg: float = Field(default=20.0, gt=0, lt=60)
    """Angle of the beams from the vertical [deg]."""
    beam_azimuth_deg: tuple[float, float, float, float] = (45.0, 135.0, -135.0, -45.0)
    """Directions of the four beams about the vertical, from forward to the left [deg]."""
    beamwidth_deg: float = Field(default=1.5, gt=0, le=20)
    """Half-power width of a beam in the echoes [deg]."""
    frequency_hz: float = Field(default=600e3, ge=200)
    """Frequency [Hz]."""
    noise_mps: float = Field(default=0.03, ge=0)
    """Standard deviation of the speed along one beam in a cell of 1 m [m/s]; it falls with the cell's height."""
    noise_cell_exponent: float = Field(default=0.5, ge=0, le=2)
    """Power of the cell's height by which the noise falls: 0.5 by the samples in a cell alone; 1 where the pulse grows
    with the cell, as in sheets of broadband profilers."""
    sound_speed_mps: float | None = Field(default=None, gt=1300, lt=1700)
    """Sound speed that turns shifts into speeds and times into ranges [m/s]; absent: that of the water at the sonar."""
    ph: float = Field(default=8.1, gt=7, lt=9)
    """Acidity of the water, for absorption."""
    lag_s: float = Field(default=1e-4, gt=0)
    """Time between the two pulses of a ping, for `iq` [s]: speeds beyond c/(4 f lag) along a beam are ambiguous."""
    source_level_db: float = Field(default=217.0, ge=0, le=300)
    """Source level [dB re 1 uPa at 1 m]."""  # assumed: of the 600 kHz class
    volume_scattering_db: float | None = Field(default=None, ge=-200, le=0)
    """Volume backscattering strength Sv of the water [dB re 1/m] in the echoes; absent: that of the ocean's tracer
    `volume_scattering_db`, and -75 where it has none: a profiler lives on what drifts in the water."""

    @model_validator(mode="after")
    def _unambiguous(self) -> Self:
        if len({azimuth % 360 for azimuth in self.beam_azimuth_deg}) < 4:
            raise ValueError("beam_azimuth_deg needs four different directions")
        reach = (self.depths[-1] + 0.5 * self.cell_m) / math.cos(math.radians(self.beam_tilt_deg))
        heard = farthest_heard(self.rate_hz, SLOWEST)
        if reach > heard:
            raise ValueError(
                f"{self.cells} cells of {self.cell_m:g} m reach {reach:.4g} m along the beams, which is ambiguous at "
                f"{self.rate_hz:g} pings a second: at most {heard:.4g} m, or {SLOWEST / (2 * reach):.3g} Hz"
            )
        return self

    @property
    def beams(self) -> NDArray[np.float64]:
        """Unit vectors `(4, 3)` of the beams in the sensor frame."""
        return janus_beams(math.radians(self.beam_tilt_deg), tuple(math.radians(a) for a in self.beam_azimuth_deg))

    @property
    def depths(self) -> NDArray[np.float64]:
        """Middle of each cell `(cells,)`, along the vertical of the sensor [m]."""
        return np.asarray(self.blank_m + (np.arange(self.cells) + 0.5) * self.cell_m, dtype=np.float64)


def beam_rays(config: AdcpConfig) -> dict[str, NDArray[Any]]:
    """One ray a beam (see `Fan`)."""
    zero = np.zeros(4)
    return {
        "direction": config.beams,
        "along": np.zeros((4, 3)),
        "aside": np.zeros((4, 3)),
        "lower": zero,
        "upper": zero,
        "weight": zero + 1.0,
        "beam": np.arange(4),
    }


class Adcp:
    """A current profiler.

    data: `(m, cells, 3)` float64, velocity of the water relative to the sensor, in the sensor frame FLU [m/s]; NaN
        where fewer than three beams are free: beyond the bottom, and where its side-lobe echo drowns the water's, from
        altitude times cos(tilt) on; all NaN in the air.
    truth: `(m, cells, 3)` the same without noise, everywhere.
    extras: `ranges` `(m, 4)`, where each beam meets something [m], infinite without; `label` and `instance` `(m, 4)`
        of it; `cell_valid` `(m, cells)`. With `water_column_bins`, `iq` or `labels` the echoes of the beams by range,
        `(m, 4, bins)` each: `water_column` and `water_column_truth` [dB], `water_column_label`,
        `water_column_instance`, and `iq` complex64 `(m, 4, 2, bins)`, before gain, of two pulses a `lag_s` apart, whose
        phases tell the speed of the water along the beams (see `speed_of_pair`).
    tables: `depth` `(cells,)`, middle of each cell along the sensor's vertical [m]; `direction` `(4, 3)`;
        `water_column_range` `(bins,)`, along the beams [m].
    """

    TITLE: ClassVar[str] = "acoustic Doppler current profiler: water velocity by depth cell"
    KERNELS: ClassVar[int] = 12
    CASTS: ClassVar[int] = 1
    MAY_LACK: ClassVar[bool] = True
    Config: ClassVar[type[SensorConfig]] = AdcpConfig
    SOURCES: ClassVar[tuple[str, ...]] = (
        "Teledyne RD Instruments, Acoustic Doppler Current Profiler: Principles of Operation (2011)",
        "D. S. Zrnic, IEEE Trans. Aerosp. Electron. Syst. 13, 344 (1977), doi 10.1109/TAES.1977.308467: pulse pairs",
        "T. K. Chereskin and A. J. Harding, J. Atmos. Oceanic Technol. 10, 41 (1993): the variance of a cell",
    )

    def __init__(self, config: AdcpConfig, context: SensorContext) -> None:
        self.config = config
        self._context = context
        warn_of_idle(config, context.path, *_OF_ECHOES)
        wind = wind_for(config.wind_speed_mps, context.ocean, context.path)
        self._mounting = mounting(config)
        self._sounder = Sounder(
            self._mounting, context, beam_rays(config), Waters(config.frequency_hz, config.ph, wind)
        )
        self._program = Program(self._kernel, self._sounder.compile)
        self.tables: dict[str, NDArray[Any]] = {"depth": config.depths, "direction": config.beams}
        self._echoes: BeamEchoes | None = None
        if config.echo_bins > 0:
            slant = 1.0 / math.cos(math.radians(config.beam_tilt_deg))
            farthest = float(config.depths[-1] + config.cell_m) * slant
            spec = echo_spec(config, context, nearest=config.blank_m * slant, farthest=farthest)
            pairs = Pairs(config.lag_s, config.noise_mps, 0.0, layer_m=slant, clear_db=_CLEAR_DB)
            width = math.radians(config.beamwidth_deg)
            self._echoes = BeamEchoes(spec, context, config.beams, width=width, pairs=pairs)
            self.tables["water_column_range"] = self._echoes.ranges

    def sense(self, motion: Kinematics) -> Measurement:
        """Ping on every lane."""
        extras = self._program(motion, self._context.ocean)
        data, truth = (extras.pop(name).reshape(-1, self.config.cells, 3) for name in ("velocity", "truth"))
        valid = extras["cell_valid"]
        if self._echoes is not None:
            extras |= self._echoes.extras(motion)
        return Measurement(np.where(valid[..., None], data, np.nan), truth, None, extras, self.tables)

    def explain(self, motion: Kinematics) -> list[tuple[str, NDArray[Any], str]]:
        """One profile, not frozen, with its intermediate arrays: (name, values, unit)."""
        return self._sounder.trace(self._kernel, motion, self._context.ocean)

    def _kernel(self, ping: Ping, ocean: Ocean, *, trace: Trace = None) -> Results:
        config, lanes, motion = self.config, ping.lanes, ping.motion
        velocity = sensor_velocity(motion, self._mounting)
        tilt = math.cos(math.radians(config.beam_tilt_deg))
        far = (config.depths[-1] + config.cell_m) / tilt**2 + 1.0
        if config.sound_speed_mps is not None:  # below the water's, cells lie farther away than they are said to
            far *= max(_FASTEST / config.sound_speed_mps, 1.0)
        view = ping.cast(max_range=float(far), smooth=False)
        first = dr.arange(jit.UInt32, dr.width(lanes.position)) * 4
        hits = view.hits
        dr.eval(hits.t, hits.label, hits.instance)
        ranges = [dr.gather(jit.Float, hits.t, first + b) for b in range(4)]
        label, instance = ([dr.gather(jit.UInt32, v, first + b) for b in range(4)] for v in (hits.label, hits.instance))
        c = lanes.medium.sound_speed
        cells = profile(config, ranges, lanes, velocity, motion, ocean, ping.key)
        if trace is not None:
            for b, r in enumerate(ranges):
                trace(f"range of beam {b}", r, "m")
            trace("water velocity of the first cell, forward", cells[0][1].x, "m/s")
            trace("measured velocity of the first cell, forward", cells[0][0].x, "m/s")
        return {
            "velocity": [component for cell in cells for component in cell[0]],
            "truth": [component for cell in cells for component in cell[1]],
            "cell_valid": [cell[2] for cell in cells],
            "ranges": ranges if config.sound_speed_mps is None else [r * (config.sound_speed_mps / c) for r in ranges],
            "label": label,
            "instance": instance,
        }


def profile(
    config: AdcpConfig, ranges: list[Array], lanes: Lanes, velocity: Array, motion: Kinematics, ocean: Ocean, key: Key
) -> list[tuple[Array, Array, Array]]:
    """Velocity, its truth [m/s] and validity of each cell.

    Every beam meets other water, by an assumed sound speed nearer or farther than the cell is said to be; the truth is
    the velocity on the axis, where it is said to be, so that shear and gradients show as errors.
    Cells are lanes: written out one after the other, thirty of them would take a minute to compile.
    """
    tilt = math.cos(math.radians(config.beam_tilt_deg))
    sigma = config.noise_mps / math.sqrt(config.cell_m ** (2.0 * config.noise_cell_exponent))
    rows = dr.width(lanes.position)
    lane = dr.arange(jit.UInt32, rows * config.cells)
    row, cell = lane // config.cells, lane % config.cells

    wet = jit.Bool(True) if lanes.wet is None else lanes.wet
    assumed = jit.Float64(1.0)
    if config.sound_speed_mps is not None:
        assumed = config.sound_speed_mps / jit.Float64(lanes.medium.sound_speed)
    seconds = jit.Float64(motion.t_ns) * 1e-9
    doubles = [v + dr.zeros(jit.Float64, rows) for v in (*lanes.position, *lanes.attitude, *velocity, seconds, assumed)]
    words = [v + dr.zeros(jit.UInt32, rows) for v in (motion.copy, motion.environment, motion.tick)]
    floats = [r + dr.zeros(jit.Float, rows) for r in (*ranges, dr.select(wet, jit.Float(1), 0.0))]
    dr.eval(doubles, words, floats)  # all at once: a gather would compute each by itself
    x, y, z, *turn, forward, left, up, t, assumed = (dr.gather(jit.Float64, v, row) for v in doubles)
    copy, environment, tick = (dr.gather(jit.UInt32, v, row) for v in words)
    *free, in_water = (dr.gather(jit.Float, v, row) for v in floats)
    place, attitude, sensor_moves = jit.Array3f64(x, y, z), jit.Array4f64(*turn), jit.Array3f64(forward, left, up)
    depth = config.blank_m + (jit.Float64(cell) + 0.5) * config.cell_m
    reach = jit.Float((depth + 0.5 * config.cell_m) / tilt) / jit.Float(assumed)  # in true range
    noise = normals64_from(key, environment, tick, 2 * cell, len(config.beams))
    speeds = []
    for b, axis in enumerate(config.beams.tolist()):
        there = place + rotate(attitude, jit.Array3f64(*axis)) * (depth / tilt) / assumed
        water = rotate_back(attitude, ocean.current(there, t, copy)) - sensor_moves
        speeds.append(water.x * axis[0] + water.y * axis[1] + water.z * axis[2] + sigma * noise[b])
    valid = [heard & (in_water > 0.5) for heard in heard_water(free, reach, tilt)]
    data, solved = velocity_from_beams([speed * assumed for speed in speeds], valid, config.beams)
    middle = place + rotate(attitude, jit.Array3f64(0.0, 0.0, -depth))
    truth = rotate_back(attitude, ocean.current(middle, t, copy)) - sensor_moves
    parts = [*data, *truth, dr.select(solved, jit.Float64(1), 0.0)]
    dr.eval(parts)
    first = dr.arange(jit.UInt32, rows) * config.cells
    cells = []
    for k in range(config.cells):
        *values, ok = (dr.gather(jit.Float64, part, first + k) for part in parts)
        cells.append((jit.Array3f64(*values[:3]), jit.Array3f64(*values[3:]), ok > 0.5))
    return cells
