"""The seed of a run, checked."""

from __future__ import annotations

import numpy as np

from pelagos.errors import ScenarioError


def seed_of(value: object) -> int:
    """A whole number from 0 on.

    Raises:
        ScenarioError: it is none.
    """
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < 0:
        raise ScenarioError(f"a seed is a whole number from 0 on, not {value!r}", where="seed")
    return int(value)
