"""Quantities read from a world: diagnostics, sensors, rays."""
