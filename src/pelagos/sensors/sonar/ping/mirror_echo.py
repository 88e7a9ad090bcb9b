"""The coherent echo of a smooth sphere, box or cylinder, computed from its shape; see `specular`."""

from __future__ import annotations

import math

import drjit as dr

from pelagos import jit
from pelagos.acoustics.specular import flat_side, round_side, sphere_amplitude
from pelagos.jit import Array
from pelagos.math.so3 import rotate
from pelagos.sensors.sonar.ping.listener import Hearing
from pelagos.sensors.sonar.ping.target_place import Place
from pelagos.sensors.sonar.ping.targets import BOX, CYLINDER, SPHERE


@jit.struct
class MirrorEcho:
    """Coherent amplitude over what the surface reflects, its range, and the place it comes from, from the sonar."""

    size: Array
    reach: Array
    way: Array


def mirror_echo(place: Place, hearing: Hearing) -> MirrorEcho:
    """The mirror's part of each thing's echo, before roughness; of a box that of its loudest side."""
    wavelength = jit.Float(hearing.wavelength)
    near = dr.maximum(place.distance - place.radius, 1e-3)
    size = dr.select(place.kind == SPHERE, sphere_amplitude(place.form, place.radius, near), 0.0)
    reach, foot = jit.Float(near), place.local * (place.radius / place.distance)
    p, h = place.local, place.half
    for a in range(3):
        u, v = (a + 1) % 3, (a + 2) % 3
        loud, far, _ = flat_side((h[u], h[v]), (p[u], p[v]), dr.abs(p[a]) - h[a], wavelength)
        loud = dr.select((place.kind == BOX) & (dr.abs(p[a]) > h[a]), loud * place.mirror, 0.0)
        spot = jit.Array3f(0)
        spot[a], spot[u], spot[v] = (
            dr.select(p[a] < 0.0, -h[a], h[a]),
            dr.clip(p[u], -h[u], h[u]),
            dr.clip(p[v], -h[v], h[v]),
        )
        louder = loud > size
        size, reach = dr.select(louder, loud, size), dr.select(louder, far, reach)
        foot = dr.select(louder, spot, foot)
    across = dr.sqrt(p.x * p.x + p.y * p.y)
    loud, far, _ = round_side(h.x, h.z, p.z, across, wavelength)
    loud = dr.select((place.kind == CYLINDER) & (across > h.x), loud * place.mirror, 0.0)
    rim = h.x / dr.maximum(across, 1e-6)
    side = jit.Array3f(p.x * rim, p.y * rim, dr.clip(p.z, -h.z, h.z))
    edge = h.x * (0.5 * math.sqrt(math.pi))  # a square as large as the cap
    cap, cap_far, _ = flat_side((edge, edge), (p.x, p.y), dr.abs(p.z) - h.z, wavelength)
    cap = dr.select((place.kind == CYLINDER) & (dr.abs(p.z) > h.z), cap * place.mirror, 0.0)
    top = jit.Array3f(dr.clip(p.x, -edge, edge), dr.clip(p.y, -edge, edge), dr.select(p.z < 0.0, -h.z, h.z))
    for loud_, far_, spot in ((loud, far, side), (cap, cap_far, top)):
        louder = loud_ > size
        size, reach = dr.select(louder, loud_, size), dr.select(louder, far_, reach)
        foot = dr.select(louder, spot, foot)
    return MirrorEcho(size, reach, rotate(place.attitude, foot - place.local))
