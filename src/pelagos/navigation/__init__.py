"""Estimation of a vehicle's motion from its sensors: arrays in, arrays out, one row a copy."""
