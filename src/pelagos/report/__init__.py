"""The page that a run leaves behind: one recording, read back, beside the world it was made in."""
