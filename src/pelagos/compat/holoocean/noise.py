"""HoloOcean's keys for noise: `XSigma` (a number or one for each element) and `XCov` (a number, a diagonal, a matrix).

Streams are named by seed, agent and sensor, so that a run with the same seed repeats.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pelagos.compat.holoocean.advice import Advice

Array = NDArray[np.float64]


def stream(seed: int, *names: str) -> np.random.Generator:
    """The random stream of these names."""
    text = "\x1f".join((str(int(seed)), *names)).encode()
    return np.random.Generator(
        np.random.Philox(int.from_bytes(hashlib.blake2b(text, digest_size=8).digest(), "little"))
    )


class Normal:
    """Gaussian noise of `size` elements.

    Attributes:
        root: `(size, size)`, a square root of the covariance; None without noise.
        scale: `(size,)` its diagonal; None where it is more than that, or nothing.
    """

    def __init__(
        self, config: Mapping[str, Any], name: str, size: int, *, advice: Advice | None = None, exclusive: bool = True
    ) -> None:
        sigma, cov = config.get(f"{name}Sigma"), config.get(f"{name}Cov")
        if sigma is not None and cov is not None and exclusive:
            raise ValueError(f"give either {name}Sigma or {name}Cov, not both")
        self.size = size
        self.root = _root(sigma, cov, size, advice, name)
        diagonal = self.root is not None and not (self.root - np.diag(np.diag(self.root))).any()
        self.scale = np.diag(self.root).copy() if diagonal and self.root is not None else None

    def draw(self, stream: np.random.Generator) -> Array | float:
        """`(size,)` numbers; 0 without noise."""
        if self.root is None:
            return 0.0
        if self.scale is not None:
            return np.asarray(self.scale * stream.standard_normal(self.size))
        return np.asarray(self.root @ stream.standard_normal(self.size))


class Normals:
    """Several noises that are drawn together, one behind the other; the numbers are those of single draws."""

    def __init__(self, parts: Sequence[Normal]) -> None:
        self._parts = [part for part in parts if part.root is not None]
        self._size = sum(part.size for part in parts)
        self._noisy = np.repeat([part.root is not None for part in parts], [part.size for part in parts])
        scales = [part.scale for part in self._parts]
        self._scale = None if any(s is None for s in scales) else np.concatenate([np.empty(0), *scales])

    def draw(self, stream: np.random.Generator) -> Array:
        """Numbers of all, 0 for those without noise."""
        drawn = np.zeros(self._size)
        if self._scale is None:
            drawn[self._noisy] = np.concatenate([part.draw(stream) for part in self._parts])
        else:
            drawn[self._noisy] = self._scale * stream.standard_normal(len(self._scale))
        return drawn


def _root(sigma: Any, cov: Any, size: int, advice: Advice | None, name: str) -> Array | None:
    if sigma is not None:
        values = np.asarray(sigma, dtype=np.float64)
        if values.ndim == 0 or values.shape in ((1,), (size,)):
            diagonal = np.broadcast_to(values.reshape(-1) if values.size > 1 else values.reshape(()), (size,))
            return np.diag(diagonal) if np.any(diagonal) else None
        raise ValueError(f"{name}Sigma is a number or {size} of them, not {sigma!r}; give a matrix as {name}Cov")
    if cov is None:
        return None
    values = np.asarray(cov, dtype=np.float64)
    if values.ndim == 0 or values.shape in ((1,), (size,)):
        diagonal = np.broadcast_to(values.reshape(-1) if values.size > 1 else values.reshape(()), (size,))
        return np.diag(np.sqrt(diagonal)) if np.any(diagonal) else None
    if values.shape != (size, size):
        raise ValueError(f"{name}Cov is a number, {size} of them, or a matrix of {size} x {size}, not {cov!r}")
    try:
        return np.asarray(np.linalg.cholesky(values), dtype=np.float64)
    except np.linalg.LinAlgError:
        if advice is not None:
            advice.once(f"{name}Cov is not positive definite; there is no such noise")
        return None
