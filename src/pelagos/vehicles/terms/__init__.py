"""The terms of a vehicle's equation of motion. Each file: a configuration, and the term built from it."""
