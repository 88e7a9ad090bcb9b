"""Paths inside a scenario: relative ones start from the scenario's own folder."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, TypeAlias

from pydantic import AfterValidator, ValidationInfo

from pelagos.config.strict import refusal


def from_folder(path: Path, info: ValidationInfo) -> Path:
    """The path from the folder that the validation's context names; from the working folder where it names none."""
    expanded = path.expanduser()
    folder = info.context.get("folder") if isinstance(info.context, dict) else None
    return expanded if expanded.is_absolute() or folder is None else (Path(folder) / expanded).resolve()


def within(path: Path, info: ValidationInfo) -> Path:
    """The same path, where it stays in the folder of a scenario's file, or the scenario is trusted."""
    context = info.context if isinstance(info.context, dict) else {}
    folder = context.get("bounds")
    if folder is not None and not context.get("trust", False) and not path.resolve().is_relative_to(folder):
        raise refusal(
            f"{path} lies outside of the scenario's folder {folder}; copy it there, or load the scenario with "
            "trust=True, or with --trust on the command line"
        )
    return path


ScenarioPath: TypeAlias = Annotated[Path, AfterValidator(from_folder)]
MeshPath: TypeAlias = Annotated[ScenarioPath, AfterValidator(within)]
