"""Names of agents and sensors, as topics and paths of Pelagos may have them."""

from __future__ import annotations

import re


def identifier(name: str) -> str:
    """A name of letters, digits and underlines that does not begin with a digit."""
    plain = re.sub(r"\W", "_", name, flags=re.ASCII)
    return plain if plain and not plain[0].isdigit() else f"_{plain}"
