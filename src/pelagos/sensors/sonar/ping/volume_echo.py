"""Echo of the water between a sonar and its targets: volume reverberation by beam and range."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any, Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.acoustics.spreading import from_db
from pelagos.jit import Array
from pelagos.sensors.sonar.ping.aperture import Facing
from pelagos.sensors.sonar.ping.clumps import Adrift, Clumps, Crowd, clumps
from pelagos.sensors.sonar.ping.fan import FanHits, Lanes
from pelagos.sensors.sonar.ping.layout import Layout
from pelagos.sensors.sonar.ping.ping_spec import PingSpec

if TYPE_CHECKING:
    from pelagos.ocean.ocean import Ocean

TRACER: Final = "volume_scattering_db"
"""Name of the ocean's tracer that is the volume backscattering strength Sv [dB re 1/m]."""
NODES: Final = 64  # ranges of each beam at which the water is looked at
_PROBES: Final = (8, 64)  # fewest and most rays of a beam that stand for all
_LOOKS: Final = 4096  # rays of a ping in all, about


@jit.struct
class Probes:
    """Rays that stand for their beam's neighbours, beams by probes: a Dr.Jit struct.

    Attributes:
        ray: `UInt32`, row of the fan.
        weight: `Float` [sr], of all the rays that it stands for, see `Fan`.
    """

    ray: Array
    weight: Array


@jit.struct
class Haze:
    """The water's echo by ping, beam and `NODES` ranges: a Dr.Jit struct.

    Attributes:
        beam: `Float`, integral of sv over the two-way power pattern where the water is open [1/m].
        nearest, step: range of the first node, distance of nodes [m].
        clumps: of few scatterers; None: there are many in every cell.
    """

    beam: Array
    nearest: float
    step: float
    clumps: Clumps | None = None


def probes(rays: dict[str, NDArray[Any]], beams: int) -> Probes:
    """Of each beam's rays, in their order, one in the middle of each of as many groups."""
    each = len(rays["beam"]) // beams
    count = min(max(_LOOKS // beams, _PROBES[0]), _PROBES[1], each)
    table = np.argsort(rays["beam"], kind="stable").reshape(beams, each)
    edges = np.linspace(0, each, count + 1).astype(int)
    middle = (edges[:-1] + edges[1:] - 1) // 2
    weight = np.add.reduceat(rays["weight"][table], edges[:-1], axis=1)
    made = Probes(
        jit.UInt32(np.ascontiguousarray(table[:, middle], dtype=np.uint32).ravel()),
        jit.Float(np.ascontiguousarray(weight, dtype=np.float32).ravel()),
    )
    jit.align(made)
    return made


def haze(
    view: FanHits, lanes: Lanes, probes: Probes, strength_db: Callable[[Array, Array], Array], t: Array, *,
    beams: int, rays: int, nearest: float, farthest: float,
) -> Haze:  # fmt: skip
    """Look at the water along each beam.

    Args:
        view: what rays saw: behind it there is no water.
        strength_db: Sv [dB re 1/m] at world places `Array3f64` and times [s].
        t: time by lane [s].
        beams, rays: of a ping.
        nearest, farthest: first and last node [m].
    """
    count = dr.width(probes.ray) // beams
    step = (farthest - nearest) / (NODES - 1)
    dr.eval(view.hits.t, view.direction)
    lane = dr.arange(jit.UInt32, dr.width(lanes.position) * beams * NODES)
    node, beam, ping = lane % NODES, lane // NODES % beams, lane // (NODES * beams)
    reach = nearest + step * jit.Float(node)
    origin = dr.gather(jit.Array3f64, lanes.position, ping)
    when = dr.gather(jit.Float64, t, ping) if dr.width(t) > 1 else t
    wet = jit.Bool(True) if lanes.wet is None else dr.gather(jit.Bool, lanes.wet, ping)

    def add(k: Array, total: Array) -> tuple[Array, Array]:
        row = beam * count + k
        ray = ping * rays + dr.gather(jit.UInt32, probes.ray, row)
        place = origin + jit.Array3f64(dr.gather(jit.Array3f, view.direction, ray)) * jit.Float64(reach)
        level = from_db(jit.Float(strength_db(place, when)))
        open_water = (reach < dr.gather(jit.Float, view.hits.t, ray)) & wet
        weight = dr.gather(jit.Float, probes.weight, row)
        return k + 1, total + dr.select(open_water, weight * level, 0.0)

    start = (dr.zeros(jit.UInt32, dr.width(lane)), dr.zeros(jit.Float, dr.width(lane)))
    _, total = dr.while_loop(start, lambda k, _: k < count, add, mode="symbolic", labels=("probe", "total"))
    dr.eval(total)
    return Haze(total, nearest, step)


@jit.struct
class OpenWater:
    """The water before a sonar: a Dr.Jit struct.

    Attributes:
        probes: rays that look at it.
        ocean: what it is made of.
        crowd: its scatterers, where they are few.
    """

    probes: Probes
    ocean: Ocean
    crowd: Crowd | None = None

    def seen(self, spec: PingSpec, layout: Layout, view: FanHits, lanes: Lanes, facing: Facing, t_ns: Array) -> Haze:
        """The water's echo at times [ns], by lane."""
        t, fixed = jit.Float64(t_ns) * 1e-9, spec.volume_scattering_db
        strength = (lambda *_: jit.Float(fixed)) if fixed is not None else partial(self.ocean.tracer, TRACER)
        found = haze(
            view, lanes, self.probes, strength, t, beams=layout.beams, rays=dr.width(view.ray) // dr.width(t),
            nearest=spec.range_min_m, farthest=spec.range_max_m,
        )  # fmt: skip
        if self.crowd is not None:
            found.clumps = clumps(spec, layout, lanes, facing, Adrift(self.crowd, self.ocean, t))
        return found


def haze_at(haze: Haze, ping: Array, beam: Array, distance: Array, beams: int) -> Array:
    """`Haze.beam` at a range, linear between nodes; `ping` and `beam` `Int32`."""
    place = dr.clip((distance - haze.nearest) * (1.0 / haze.step), 0.0, NODES - 1.0)
    node = dr.minimum(jit.UInt32(place), NODES - 2)
    index = jit.UInt32(ping * beams + dr.minimum(beam, beams - 1)) * NODES + node
    low = dr.gather(jit.Float, haze.beam, index)
    return dr.lerp(low, dr.gather(jit.Float, haze.beam, index + 1), place - jit.Float(node))
