"""The cases; each module has a tuple `CASES`."""
