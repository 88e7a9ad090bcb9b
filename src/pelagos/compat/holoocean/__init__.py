"""HoloOcean's interface, spoken by Pelagos: names, frames and units are translated; the native parts do the work."""
