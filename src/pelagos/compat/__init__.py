"""Other simulators' interfaces, on Pelagos."""
