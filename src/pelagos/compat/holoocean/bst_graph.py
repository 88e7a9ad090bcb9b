"""HoloOcean's visualiser of biomass, salinity and temperature: six maps about a place, refreshed as it moves."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import numpy as np

HALF_WIDTH_M: Final = 75.0
POINTS: Final = 25
MAPS: Final = {
    "biomass": ("Greens", (0.0, 3.0)), "salinity": ("Blues", (32.75, 34.0)), "temperature": ("Reds", (5.0, 25.0)),
}  # fmt: skip
Field = Callable[[Any], Any]


class BST_Visualizer:  # noqa: N801
    """Maps x-y and x-z of three fields; each a function of a location `(3,)`.

    Functions are given as `biomass_function` or, as HoloOcean's examples do, `biomass_func`; without one, the field is
    that of the first BSTSensor in `config`.
    """

    def __init__(
        self,
        config: Any = None,
        biomass_function: Field | None = None,
        salinity_function: Field | None = None,
        temperature_function: Field | None = None,
        agent: str | None = None,
        *,
        biomass_func: Field | None = None,
        salinity_func: Field | None = None,
        temperature_func: Field | None = None,
    ) -> None:
        from pelagos.compat.holoocean.water_sensors import BSTSensor

        keys = _config_of(config, agent)
        self.fields: dict[str, Field] = {
            "biomass": biomass_function or biomass_func or BSTSensor.biomass_model(**keys),
            "salinity": salinity_function or salinity_func or BSTSensor.salinity_model(**keys),
            "temperature": temperature_function or temperature_func or BSTSensor.temperature_model(**keys),
        }
        self.location = np.zeros(3)
        self._figure: Any = None

    def update_position(self, location: Any) -> None:
        """The middle of the maps."""
        self.location = np.asarray(location, dtype=np.float64)

    def update(self, location: Any = None) -> None:
        """Another middle, and the maps anew."""
        if location is not None:
            self.update_position(location)
        self.update_plots()

    def maps(self) -> dict[str, Any]:
        """`(25, 25)` values by "biomass xy", "biomass xz" and so on."""
        along = np.linspace(-HALF_WIDTH_M, HALF_WIDTH_M, POINTS)
        found = {}
        for name, field in self.fields.items():
            for plane, axis in (("xy", 1), ("xz", 2)):
                values = np.empty((POINTS, POINTS))
                for i, a in enumerate(along):
                    for j, b in enumerate(along):
                        at = self.location.copy()
                        at[0] += a
                        at[axis] += b
                        values[j, i] = float(np.ravel(field(at))[0])
                found[f"{name} {plane}"] = values
        return found

    def update_plots(self) -> None:
        """Draw the maps."""
        import matplotlib.pyplot as plt

        if self._figure is None:
            self._figure = plt.subplots(2, 3, figsize=(12, 7))
        figure, axes = self._figure
        for name, values in self.maps().items():
            field, plane = name.split()
            colors, limits = MAPS[field]
            place = axes[0 if plane == "xy" else 1][list(MAPS).index(field)]
            place.clear()
            extent = (-HALF_WIDTH_M, HALF_WIDTH_M, -HALF_WIDTH_M, HALF_WIDTH_M)
            place.imshow(values, origin="lower", cmap=colors, vmin=limits[0], vmax=limits[1], extent=extent)
            place.set_title(name)
        figure.canvas.draw_idle()

    def show(self) -> None:
        """Open the window, where there is one."""
        import matplotlib.pyplot as plt

        self.update_plots()
        plt.show(block=False)

    def close(self) -> None:
        """Close it."""
        import matplotlib.pyplot as plt

        if self._figure is not None:
            plt.close(self._figure[0])
            self._figure = None


def _config_of(scenario: Any, agent: str | None) -> dict[str, Any]:
    """The configuration of the first BSTSensor of a scenario, or of one agent's."""
    for one in (scenario or {}).get("agents", ()):
        for sensor in one["sensors"] if agent in (None, one["agent_name"]) else ():
            if sensor["sensor_type"] == "BSTSensor":
                return dict(sensor.get("configuration") or {})
    return {}
