"""Contacts between pairs of 2D shapes: the pair table and one file for each family of pairs."""
