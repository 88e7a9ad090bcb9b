"""Check of a sensor of one's own: its readings follow from the motion alone, in whatever order it is asked.

The contract tests of the built-in sensors ask the same of each; a package of its own has this function for its tests.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import numpy as np

from pelagos.errors import KernelError
from pelagos.sensors.example_motion import lanes
from pelagos.sensors.sensor import Kinematics, Measurement, Sensor, SensorConfig, SensorContext

_TICKS: Final = (3, 4, 5)
_COPIES: Final = 2


def check_sensor(
    kind: type[Sensor], config: SensorConfig | None = None, *, world: Any = None, ocean: Any = None
) -> None:
    """Raise unless a sensor reads the same in a block of ticks, tick by tick, and once more.

    Args:
        kind: the sensor's class.
        config: absent: `kind.Config()`.
        world, ocean: see `SensorContext.alone`; absent: a flat bottom 20 m below the surface.

    Raises:
        KernelError: a reading has another number of lanes than its motion, depends on readings before it, or holds
            numbers that are not finite in valid lanes without saying `MAY_LACK`.
    """
    around = {"type": "flat", "depth_m": 20.0} if world is None else world
    context = SensorContext.alone(world=around, ocean=ocean, copies=_COPIES)
    default: Callable[[], SensorConfig] = kind.Config
    sensor = kind(default() if config is None else config, context)
    name, dt_ns = kind.__name__, context.dt_ns
    block = sensor.sense(_motion(_TICKS, dt_ns))
    _check_lanes(name, block, len(_TICKS) * _COPIES, bool(getattr(kind, "MAY_LACK", False)))
    for asked in ("tick by tick", "once more, and backwards"):
        ticks = _TICKS if asked == "tick by tick" else _TICKS[::-1]
        for tick in ticks:
            one = sensor.sense(_motion((tick,), dt_ns))
            first = _TICKS.index(tick) * _COPIES
            _check_same(f"{name}, asked {asked}", block, one, slice(first, first + _COPIES), tick)


def _motion(ticks: tuple[int, ...], dt_ns: int) -> Kinematics:
    """Motion that is unequal on all axes, the same on every lane."""
    return lanes(
        ticks,
        dt_ns=dt_ns,
        environments=range(_COPIES),
        position=(3.0, -2.0, -4.0),
        attitude=(0.92, 0.06, -0.11, 0.37),
        velocity=(1.3, -0.2, 0.1),
        angular_velocity=(0.1, -0.2, 0.3),
        acceleration=(0.2, 0.1, -0.3),
        angular_acceleration=(-0.02, 0.03, 0.05),
    )


def _check_lanes(name: str, found: Measurement, count: int, may_lack: bool) -> None:
    for what, values in {"data": found.data, "truth": found.truth, **found.extras}.items():
        if not isinstance(values, np.ndarray) or len(values) != count:
            shape = values.shape if isinstance(values, np.ndarray) else type(values).__name__
            raise KernelError(
                f"{name}.sense: {what!r} is {shape}; it has {count} lanes as its first axis, as motion has"
            )
    data = found.data if found.valid is None else found.data[found.valid]
    if data.dtype.kind in "fc" and not may_lack and not np.isfinite(data).all():
        raise KernelError(
            f"{name}.sense: data of valid lanes are not finite, which stops a run; mark these lanes in `valid`, or say "
            "MAY_LACK: ClassVar[bool] = True"
        )


def _check_same(asked: str, block: Measurement, one: Measurement, rows: slice, tick: int) -> None:
    pairs = {"data": (block.data, one.data), "truth": (block.truth, one.truth)}
    pairs |= {extra: (values, one.extras[extra]) for extra, values in block.extras.items()}
    for what, (before, now) in pairs.items():
        if before[rows].tobytes() != now.tobytes():
            raise KernelError(
                f"{asked}: {what!r} of tick {tick} is {_start(now)}, but was {_start(before[rows])} in a block of "
                "ticks. A sensor keeps nothing from reading to reading (in self, in a random generator): what "
                "changes follows from motion.tick and motion.t_ns, and noise from `noise.NumpyNoise`"
            )


def _start(values: Any) -> str:
    return f"{np.asarray(values).ravel()[0]:.6g}" if np.asarray(values).dtype.kind in "fiu" else "other"
