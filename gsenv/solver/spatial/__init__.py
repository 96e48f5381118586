"""Three dimensions: geometry and Jacobians. Mirrors planar/ file by file."""

from gsenv.solver.spatial.shapes import Box, Capsule, Cylinder, Heightfield, Hull, Plane, Shape, Sphere

__all__ = ["Box", "Capsule", "Cylinder", "Heightfield", "Hull", "Plane", "Shape", "Sphere"]
