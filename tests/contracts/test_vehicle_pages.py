"""The pages of docs/vehicles are those that the catalogue gives (python -m pelagos.vehicles.page docs/vehicles)."""

from __future__ import annotations

from pathlib import Path

import pytest

from pelagos.vehicles.load import catalogue_names
from pelagos.vehicles.page import page

DOCS = Path(__file__).parents[2] / "docs"


@pytest.mark.parametrize("name", catalogue_names())
def test_page_is_up_to_date(name):
    assert (DOCS / "vehicles" / f"{name}.md").read_text(encoding="utf-8") == page(name)


def test_overview_names_every_vehicle():
    text = (DOCS / "vehicles.md").read_text(encoding="utf-8")
    assert [n for n in catalogue_names() if f"vehicles/{n}.md" not in text] == []
