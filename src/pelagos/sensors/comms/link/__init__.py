"""Links: the way of signals from one place to another; instruments stand in the room above."""
