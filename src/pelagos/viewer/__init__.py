"""See a simulation or a recording live, in a browser."""
