"""HoloOcean's shared memory: an array of this process, since there is no engine beside it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np


class Shmem:
    """An array `np_array` by a name."""

    def __init__(self, name: str, shape: Sequence[int], dtype: Any = np.float32, uuid: str = "") -> None:
        self.name, self.shape = name, tuple(shape)
        self.np_array = np.zeros(self.shape, dtype=dtype)

    def unlink(self) -> None:
        """Let go."""
