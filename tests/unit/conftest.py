"""Small pictures for tests that ask whether there are any."""

import pytest


@pytest.fixture
def small_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Maps and views of worlds with a tenth of the pixels along each side."""
    from pelagos.world.preview import draw_map, render

    monkeypatch.setitem(draw_map.__kwdefaults__, "pixels", 90)
    monkeypatch.setitem(render.__kwdefaults__, "size", (112, 70))


@pytest.fixture
def no_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Reports whose figures are made, but not drawn: their sections and numbers are asked for alone."""
    from pelagos.report import theme

    monkeypatch.setattr(theme, "as_png", lambda drawn, dpi=150: b"")
