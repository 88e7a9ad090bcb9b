"""HoloOcean's controller of the tide, by its older name."""

from pelagos.compat.holoocean.tides import TideController as TideController
