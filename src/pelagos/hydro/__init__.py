"""Hydrodynamics as pure functions, NED and FRD as the books have them.

F21 in these files: T. I. Fossen, "Handbook of Marine Craft Hydrodynamics and Motion Control", 2nd ed., Wiley 2021.
"""
