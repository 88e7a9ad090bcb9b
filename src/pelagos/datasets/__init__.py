"""Data sets: labelled readings at random poses in random worlds, in the formats that learners read; and sweeps."""
