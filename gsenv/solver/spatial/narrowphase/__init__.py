"""Contacts between pairs of 3D shapes: the pair table and one file for each family of pairs."""
