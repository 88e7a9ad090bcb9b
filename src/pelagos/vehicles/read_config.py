"""A vehicle's configuration from a file or its keys, with errors that name the key."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from pelagos.config.document import Document, read_document
from pelagos.config.problem import scenario_error
from pelagos.errors import ScenarioError
from pelagos.vehicles.config import VehicleConfig


def read_config(path: str | Path, *, trust: bool) -> VehicleConfig:
    """A vehicle's configuration from a YAML file; errors and `trust` as of `Vehicle.from_yaml`."""
    document = read_document(Path(path))
    if not isinstance(document.data, Mapping):
        raise ScenarioError("must be a mapping of keys", where=str(path))
    context = {"folder": document.folder, "bounds": document.folder, "trust": trust}
    return _checked(replace(document, places={(): str(path)} | document.places), context)


def checked_config(data: Any, *, where: str, context: Mapping[str, Any] | None = None) -> VehicleConfig:
    """A vehicle's configuration from its keys.

    Raises:
        ScenarioError: names the key, what was given and why it cannot be.
    """
    return _checked(Document(data, {(): where}), context)


def _checked(document: Document, context: Mapping[str, Any] | None) -> VehicleConfig:
    try:
        return VehicleConfig.model_validate(document.data, context=dict(context) if context else None)
    except ValidationError as error:
        raise scenario_error(error, document, VehicleConfig) from None
