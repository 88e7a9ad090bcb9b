"""Props and drawings of an environment."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Final, cast

import numpy as np

from pelagos.compat.holoocean.exceptions import HoloOceanException
from pelagos.compat.holoocean.frames import quaternion_of
from pelagos.errors import did_you_mean
from pelagos.sim.falling import Falling
from pelagos.world.body import Prop

if TYPE_CHECKING:
    from pelagos.compat.holoocean.environments import HoloOceanEnvironment

SHAPES: Final = ("box", "sphere", "cylinder", "cone")
MATERIALS: Final = {
    "": "concrete", "white": "white", "gold": "gold", "cobblestone": "cobblestone", "brick": "brick", "wood": "wood",
    "grass": "grass", "steel": "steel", "black": "black",
}  # fmt: skip
"""HoloOcean's materials of props, and what they are here."""


class Drawing:
    """Props, lines, arrows, boxes and points."""

    def _begin_drawing(self) -> None:
        self._props: list[tuple[Prop, bool]] = []
        self._falling: list[Falling] = []
        self._fences = False
        self.drawings: list[dict[str, Any]] = []

    def spawn_prop(
        self,
        prop_type: str,
        location: Sequence[float] | None = None,
        rotation: Sequence[float] | None = None,
        scale: Any = 1,
        sim_physics: bool = False,
        material: str = "",
        tag: str = "",
    ) -> None:
        """A box, sphere, cylinder or cone of 1 m by `scale`; with `sim_physics` it falls until something holds it.

        Raises:
            HoloOceanException: an unknown shape or material.
        """
        shape, made_of = str(prop_type).lower(), str(material).lower()
        if shape not in SHAPES:
            raise HoloOceanException(f"a prop is {', '.join(SHAPES)}, not {prop_type!r}{did_you_mean(shape, SHAPES)}")
        if made_of not in MATERIALS:
            raise HoloOceanException(
                f"a prop's material is {', '.join(k for k in MATERIALS if k)}, not {material!r}"
                f"{did_you_mean(made_of, MATERIALS)}"
            )
        size = np.broadcast_to(np.asarray(scale, dtype=np.float64), (3,))
        prop = Prop(
            shape, position=tuple(float(v) for v in _given(location)), size=tuple(float(v) for v in size),
            attitude=tuple(float(v) for v in quaternion_of(_given(rotation))), material=MATERIALS[made_of],
        )  # fmt: skip
        self._props.append((prop, bool(sim_physics)))
        self._place(prop, bool(sim_physics))

    def _place(self, prop: Prop, falls: bool) -> None:
        env = cast("HoloOceanEnvironment", self)
        body = env.pelagos.spawn(prop)
        if falls:
            self._falling.append(Falling(body, prop.extent[2] / 2, max(prop.extent[:2]) / 2))

    def _restore_props(self) -> None:
        """After the native simulation was made anew."""
        self._falling.clear()
        for prop, falls in self._props:
            self._place(prop, falls)

    def _fall(self) -> None:
        """A tick of what falls."""
        env = cast("HoloOceanEnvironment", self)
        for one in self._falling:
            one.step(env.pelagos, env._dt)
        self._falling = [one for one in self._falling if not one.rests]

    def draw_line(
        self,
        start: Sequence[float],
        end: Sequence[float],
        color: Any = None,
        thickness: float = 10.0,
        lifetime: float = 1.0,
    ) -> None:
        """A line between two points [m]."""
        self._draw("line", start, end, color, thickness, lifetime)

    def draw_arrow(
        self,
        start: Sequence[float],
        end: Sequence[float],
        color: Any = None,
        thickness: float = 10.0,
        lifetime: float = 1.0,
    ) -> None:
        """An arrow from one point to another [m]."""
        self._draw("arrow", start, end, color, thickness, lifetime)

    def draw_box(
        self,
        center: Sequence[float],
        extent: Sequence[float],
        color: Any = None,
        thickness: float = 10.0,
        lifetime: float = 1.0,
    ) -> None:
        """A box about a centre, `extent` to each side [m]."""
        self._draw("box", center, extent, color, thickness, lifetime)

    def draw_point(
        self, loc: Sequence[float], color: Any = None, thickness: float = 10.0, lifetime: float = 1.0
    ) -> None:
        """A point [m]."""
        self._draw("point", loc, [0, 0, 0], color, thickness, lifetime)

    def _draw(self, kind: str, start: Any, end: Any, color: Any, thickness: float, lifetime: float) -> None:
        """Note a drawing: `drawings` lists them with the time until which they stand.

        Raises:
            TypeError: what should be a list is none, as HoloOcean has it.
        """
        color = [255, 0, 0] if color is None else color
        for name, value in (("start", start), ("end", end), ("color", color)):
            if not isinstance(value, list):
                raise TypeError(f"{name} of a drawing is a list of three numbers, not {type(value).__name__}")
            if len(value) != 3:
                raise HoloOceanException(f"{name} of a drawing is three numbers, not {value!r}")
        env = cast("HoloOceanEnvironment", self)
        env.advice.once("there is no window to draw in; env.drawings lists what was drawn")
        now = env._num_ticks / env._ticks_per_sec
        self.drawings = [d for d in self.drawings if d["until"] >= now]
        until = np.inf if lifetime == 0 else now + lifetime
        self.drawings.append(
            {"kind": kind, "start": start, "end": end, "color": color, "thickness": thickness, "until": until}
        )

    def draw_debug_vector_field(
        self,
        vector_field_function: Callable[[Any], Any],
        location: Sequence[float] = (0, 0, 0),
        vector_field_dimensions: Sequence[float] = (30, 30, 30),
        spacing: float = 20,
        arrow_thickness: float = 10,
        arrow_size: float = 1,
        lifetime: float = 40,
    ) -> None:
        """Arrows of a field about a place: x and y on both sides, z from the surface down."""
        x, y, z = (float(v) for v in vector_field_dimensions)
        for i in _steps(-x / 2, x / 2, spacing):
            for j in _steps(-y / 2, y / 2, spacing):
                for k in _steps(-z, 0.0, spacing):
                    at = np.array([location[0] + i, location[1] + j, k])
                    end = at + arrow_size * np.asarray(vector_field_function(at), dtype=np.float64)
                    self.draw_arrow([float(v) for v in at], [float(v) for v in end], None, arrow_thickness, lifetime)

    @staticmethod
    def centered_range(num_points: int, spacing: float = 1.0) -> Any:
        """So many numbers about 0, `spacing` apart."""
        return (np.arange(num_points) - (num_points - 1) / 2) * spacing


def _given(values: Sequence[float] | None) -> Sequence[float]:
    """Three numbers, zeros where none are given."""
    return (0.0, 0.0, 0.0) if values is None else values


def _steps(low: float, high: float, spacing: float) -> Any:
    return np.arange(low, high + 1e-9, spacing)
