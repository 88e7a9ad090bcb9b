"""Where things of a generated world may stand."""

from __future__ import annotations

import numpy as np
import pytest

from pelagos.world.generate.kinds.natural import NATURAL
from pelagos.world.generate.objects import ObjectConfig, _Suits
from pelagos.world.terrain import HeightField


@pytest.mark.parametrize("size", [0.5, 3.0])
def test_a_thing_stands_where_water_is_as_deep_as_its_size_asks(size: float) -> None:
    kind = next(k for k in NATURAL.values() if k.needs_depth > 0)
    least = kind.needs_depth * size
    for share in (0.9, 1.1):
        ground = HeightField(-10.0, -10.0, 2.0, np.full((11, 11), -share * least))
        suits = _Suits(ground, ObjectConfig(kind=next(n for n, k in NATURAL.items() if k is kind), count=1), kind, size)
        assert suits(1.0, -2.0) == (share > 1)
