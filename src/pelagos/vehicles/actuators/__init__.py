"""Actuators: a state that follows a command, and a wrench. Each file: a configuration, and what is built from it."""
