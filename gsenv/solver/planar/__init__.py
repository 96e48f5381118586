"""The planar (2D) half of the solver: poses (x, y, angle), y up."""
