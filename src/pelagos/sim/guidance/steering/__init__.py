"""Goals as set-points of control modes: one steering for each family of vehicles."""
