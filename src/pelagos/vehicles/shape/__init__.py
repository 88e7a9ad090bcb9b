"""Shapes of vehicles: meshes in the body frame FLU from a few dimensions, and probes that feel contact."""
