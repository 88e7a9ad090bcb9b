"""Scenarios as the command line loads them: data, or a program where the user trusts it."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from pelagos.config.loader import load_scenario
from pelagos.config.scenario import Scenario


def load(
    path: Path, changes: Sequence[str] = (), *, overrides: Mapping[str, Any] | None = None, trust: bool = False
) -> Scenario:
    """The scenario of a file; one that is trusted may name functions of modules that lie beside it.

    Raises:
        ScenarioError: something is wrong with it.
    """
    if trust:
        folder = str(path.resolve().parent)
        if folder not in sys.path:
            sys.path.append(folder)  # last: it replaces no installed module
    return load_scenario(path, overrides=overrides, changes=changes, trust=trust)
