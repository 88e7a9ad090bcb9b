"""The module `holoocean.holoocean`."""

from __future__ import annotations


class GL_VERSION:  # noqa: N801
    """Versions of OpenGL; accepted, and without effect."""

    OPENGL4 = 4
    OPENGL3 = 3


def __getattr__(name: str) -> object:
    if name == "make":
        from pelagos.compat.holoocean.making import make

        return make
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
