"""HoloOcean's client: scripts and tests make one; here there is nothing to connect to."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pelagos.compat.holoocean.command import CommandCenter


class HoloOceanClient:
    """Named arrays of one process."""

    def __init__(self, uuid: str = "", **_: Any) -> None:
        self._uuid, self._memory = uuid, dict[str, NDArray[Any]]()
        self.command_center = CommandCenter(self)

    def acquire(self, timeout: float = 60) -> None:
        """Nothing to wait for."""

    def release(self) -> None:
        """Nothing to let go."""

    def malloc(self, key: str, shape: Sequence[int], dtype: Any) -> NDArray[Any]:
        """The array of a name; the same as before where shape and type are."""
        held = self._memory.get(key)
        if held is None or held.shape != tuple(shape) or held.dtype != np.dtype(dtype):
            self._memory[key] = np.zeros(shape, dtype=dtype)
        return self._memory[key]
