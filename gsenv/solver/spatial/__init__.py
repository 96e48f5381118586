"""Three dimensions: geometry and Jacobians. Mirrors planar/ file by file."""
