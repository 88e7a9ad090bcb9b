"""Branches whose derivatives are right in forward mode too."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import drjit as dr

from pelagos.jit import Array


def either(
    given: Sequence[Any], condition: Array, then: Callable[..., list[Array]], otherwise: Callable[..., list[Array]]
) -> list[Array]:
    """`then(*given)` where `condition` holds, `otherwise(*given)` elsewhere: lists of arrays, one as long as the other.

    Each lane computes its own side alone. Dr.Jit 1.5 counts tangents of the arguments of an `if_stmt` twice in forward
    mode, but those of what its sides take from outside once: where derivatives are followed, all is taken from outside.
    """
    found: list[Array]
    if dr.grad_enabled(given):
        found = dr.if_stmt((), condition, lambda: then(*given), lambda: otherwise(*given))
    else:
        found = dr.if_stmt(tuple(given), condition, then, otherwise)
    return found
