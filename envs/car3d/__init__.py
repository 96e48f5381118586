"""GCar3D-v0."""
