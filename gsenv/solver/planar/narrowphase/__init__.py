"""Contacts between pairs of planar shapes: the pair table and one file a family of pairs."""

from gsenv.solver.planar.narrowphase.find import find_contacts

__all__ = ["find_contacts"]
