"""Shared by both dimensions: what knows rows, bodies and time, but no geometry."""
