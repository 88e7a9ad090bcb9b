"""Props of a scenario among the bodies of the moving scene: put there, and put back where an episode begins."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pelagos.config.prop import PropConfig
from pelagos.errors import PelagosError, ScenarioError, UnknownKey
from pelagos.math.so3 import from_euler
from pelagos.raycast.geometry import Geometry
from pelagos.sim.bodies import Bodies, Body
from pelagos.world.body import Prop
from pelagos.world.world import World

if TYPE_CHECKING:
    from pelagos.sim.model import Model
    from pelagos.sim.variety import Variety


def put(model: Model, bodies: Bodies, variety: Variety, where: NDArray[np.bool_], number: NDArray[np.int64]) -> None:
    """Put the scenario's props where the episodes `number` `(n,)` of the copies `where` `(n,)` have them, at rest.

    One that was removed comes back where all copies begin.

    Raises:
        ScenarioError: an unknown material or label, or a mesh file that cannot be used.
    """
    configs = model.scenario.props
    if not configs:
        return
    poses, there = variety.props(where, number), props_of(bodies)
    for i, name in enumerate(configs):
        position, attitude = poses[name]
        if name not in there and where.all():
            there[name] = _add(model, bodies, name, i)
        if name in there:
            body = there[name]
            still = np.zeros((model.n, 3))
            body.move(
                position=_chosen(where, position, body.position),
                attitude=_chosen(where, attitude, body.attitude),
                velocity=_chosen(where, still, body.velocity),
                angular_velocity=_chosen(where, still, body.angular_velocity),
            )


class Props(dict[str, Body]):
    """The scenario's props that are in the world, by name."""

    def __missing__(self, name: object) -> Body:
        raise UnknownKey("prop", name, self)


def props_of(bodies: Bodies) -> Props:
    """Those of the scenario that are in the world now, by name."""
    return Props({body.name: body for body in bodies.bodies if body.of_scenario})


def attitude_of(orientation_deg: Sequence[float]) -> tuple[float, ...]:
    """(w, x, y, z) of a prop, its own axes to world NWU, by its roll, pitch and yaw [deg]."""
    return tuple(float(c) for c in from_euler(*(math.radians(angle) for angle in orientation_deg)))


def geometry_of(config: PropConfig, instance: int, world: World) -> Geometry:
    """A prop's geometry in its own frame.

    Raises:
        LookupFailed: unknown material or label.
        WorldError: the mesh file cannot be used.
    """
    prop = Prop(config.shape, size=config.size_m, material=config.material, label=config.label, path=config.path)
    return prop.geometry(instance=instance, world=world)


def _chosen(where: NDArray[np.bool_], new: NDArray[np.float64], now: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.where(where[:, None], new, now)


def _add(model: Model, bodies: Bodies, name: str, number: int) -> Body:
    config = model.scenario.props[name]
    try:
        geometry = geometry_of(config, bodies.instance_of_prop(number), model.world)
        return bodies.add(name, geometry, config.position_m, attitude_of(config.orientation_deg), prop=number)
    except PelagosError as error:
        raise ScenarioError(str(error), where=model.scenario.where("props", name)) from None
