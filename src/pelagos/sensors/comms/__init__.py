"""Modems, positioning, hydrophones and radio: one file an instrument."""
