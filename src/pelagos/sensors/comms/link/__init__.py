"""How signals get from one place to another; instruments stand in the room above."""
