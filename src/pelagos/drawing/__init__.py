"""Drawing shared by reports, the view and notebooks: colour maps, shaded ground, pictures of readings."""
