"""The table of sonar levels in the docs is what is measured, and within a decibel and a bit of theory."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


@pytest.mark.slow  # 15 s
def test_the_docs_table_is_measured():
    spec = importlib.util.spec_from_file_location("sonar_levels", ROOT / "examples" / "sonar_levels.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    docs = (ROOT / "docs" / "sonars.md").read_text().splitlines()
    lines = module.table()
    assert len(lines) > 12
    for line in lines[2:]:
        name, _, expected, measured, _ = (cell.strip() for cell in line.strip("|").split("|"))
        told = [row for row in docs if row.startswith(f"| {name} |")]
        assert len(told) == 1, name
        assert abs(float(told[0].split("|")[4]) - float(measured)) <= 0.11, name
        assert abs(float(measured) - float(expected)) <= 1.2, name
