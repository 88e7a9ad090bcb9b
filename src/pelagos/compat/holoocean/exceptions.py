"""HoloOcean's exceptions, by its names."""

from __future__ import annotations


class HoloOceanException(Exception):
    """Anything that HoloOcean refuses."""


class HoloOceanConfigurationException(HoloOceanException):
    """A configuration that cannot be."""


class TimeoutException(HoloOceanException):
    """Kept for scripts that catch it; Pelagos runs in the same process and waits for nothing."""


class NotFoundException(HoloOceanException):
    """A package or a file that is not there."""
