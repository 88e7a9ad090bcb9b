"""Instruments' own languages as pure functions, and the ports on which they are spoken."""
