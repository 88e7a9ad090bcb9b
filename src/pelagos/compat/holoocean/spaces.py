"""Spaces of actions: what an agent may be told."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np


class ActionSpace(ABC):
    """An array of a shape; `buffer_shape` is accepted for scripts, and is the shape where not given."""

    def __init__(self, shape: Sequence[int], buffer_shape: Sequence[int] | None = None) -> None:
        self._shape = list(shape)
        self.buffer_shape = list(buffer_shape) if buffer_shape is not None else self._shape

    @property
    def shape(self) -> list[int]:
        """Of an action."""
        return self._shape

    @abstractmethod
    def sample(self) -> Any:
        """A random action."""

    @abstractmethod
    def get_low(self) -> Any:
        """Least values."""

    @abstractmethod
    def get_high(self) -> Any:
        """Greatest values."""


class ContinuousActionSpace(ActionSpace):
    """Real numbers between limits; samples are unit Gaussians, as HoloOcean's are, unless `sample_fn` is given."""

    def __init__(
        self,
        shape: Sequence[int],
        low: Any = None,
        high: Any = None,
        sample_fn: Callable[[], Any] | None = None,
        buffer_shape: Sequence[int] | None = None,
    ) -> None:
        super().__init__(shape, buffer_shape)
        self.low, self.high, self.sample_fn = low, high, sample_fn

    def get_low(self) -> Any:
        """Least values."""
        return self.low

    def get_high(self) -> Any:
        """Greatest values."""
        return self.high

    def sample(self) -> Any:
        """A random action."""
        if self.sample_fn is not None:
            return self.sample_fn()
        return np.random.default_rng().normal(size=self._shape)

    def __repr__(self) -> str:
        return f"[ContinuousActionSpace: shape {self._shape}, low {self.low}, high {self.high}]"


class DiscreteActionSpace(ActionSpace):
    """Whole numbers from `low` up to, but not including, `high`."""

    def __init__(self, shape: Sequence[int], low: int, high: int, buffer_shape: Sequence[int] | None = None) -> None:
        super().__init__(shape, buffer_shape)
        self.low, self.high = low, high

    def get_low(self) -> int:
        """Least value."""
        return self.low

    def get_high(self) -> int:
        """Greatest value."""
        return self.high

    def sample(self) -> Any:
        """A random action."""
        return np.random.default_rng().integers(self.low, self.high, self._shape, dtype=np.int32)

    def __repr__(self) -> str:
        return f"[DiscreteActionSpace: shape {self._shape}, low {self.low}, high {self.high}]"
