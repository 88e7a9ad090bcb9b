"""Seas that differ from copy to copy: wave systems with numbers that were drawn."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pelagos.config.vary import WAVES, Varied, with_number
from pelagos.errors import ScenarioError
from pelagos.ocean.config import site_of
from pelagos.ocean.site import Site
from pelagos.ocean.wave_system import Components
from pelagos.ocean.waves import Waves, sea_of, waves_by_copy

if TYPE_CHECKING:
    from pelagos.sim.model import Model
    from pelagos.world.world import World


def written_by_copy(config: Any, world: World, *, seed: int, n: int) -> Waves:
    """The sea of an ocean's configuration in every one of `n` copies, which others may take the place of."""
    return _by_copy(config, [_written(config, site_of(world, seed))] * n)


def _written(config: Any, site: Site) -> Components:
    return sea_of(config.waves, site, depth=config.waves_depth_m)


def _by_copy(config: Any, seas: Sequence[Components]) -> Waves:
    count = sum(getattr(system, "components_count", 1) for system in config.waves)
    return waves_by_copy(seas, count=count, depth=config.waves_depth_m, wind=config.wind.speed_mps or None)


class VariedSea:
    """The sea of each copy of a fleet.

    Args:
        model: of the fleet.
        keys: all that its scenario varies.
    """

    def __init__(self, model: Model, keys: Mapping[str, Varied]) -> None:
        self._scenario, self._first = model.scenario, model.first_environment
        self._site = site_of(model.world, model.seed)
        self._keys = {key: v for key, v in keys.items() if v.group == WAVES}
        self._made: list[tuple[tuple[float, ...], Components] | None] = [None] * model.n

    def __bool__(self) -> bool:
        return bool(self._keys)

    def waves(self, values: Mapping[str, NDArray[np.float64]], where: NDArray[np.bool_] | None = None) -> Waves:
        """The seas of all copies.

        Args:
            values: what was drawn, `(n,)` by key.
            where: `(n,)`, the copies that it was drawn for; the others have the scenario's sea, or what they had.

        Raises:
            ScenarioError: a wave system cannot have what was drawn.
        """
        config, seas = self._scenario.ocean, []
        for i in range(len(self._made)):
            drawn = tuple(float(values[key][i]) for key in self._keys)
            last = self._made[i]
            if where is not None and not where[i]:
                seas.append(_written(config, self._site) if last is None else last[1])
                continue
            if last is None or last[0] != drawn:
                systems = self._drawn(dict(zip(self._keys, drawn, strict=True)), self._first + i)
                last = self._made[i] = drawn, sea_of(systems, self._site, depth=config.waves_depth_m)
            seas.append(last[1])
        return _by_copy(config, seas)

    def _drawn(self, values: Mapping[str, float], environment: int) -> tuple[Any, ...]:
        systems = list(self._scenario.ocean.waves)
        for key, value in values.items():
            varied = self._keys[key]
            try:
                systems[int(varied.name)] = with_number(systems[int(varied.name)], varied.number, value)
            except ValueError as error:
                text = f"what was drawn for {key} in environment {environment}: {error}"
                raise ScenarioError(text, where=self._scenario.where("vary")) from None
        return tuple(systems)
