"""Paths inside a scenario: relative ones start from the scenario's own folder."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, TypeAlias

from pydantic import AfterValidator, ValidationInfo


def from_folder(path: Path, info: ValidationInfo) -> Path:
    """The path from the folder that the validation's context names; from the working folder where it names none."""
    expanded = path.expanduser()
    folder = info.context.get("folder") if isinstance(info.context, dict) else None
    return expanded if expanded.is_absolute() or folder is None else (Path(folder) / expanded).resolve()


ScenarioPath: TypeAlias = Annotated[Path, AfterValidator(from_folder)]
