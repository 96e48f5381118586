"""Contacts between shapes."""

from gsenv.solver.spatial.narrowphase.find import find_contacts

__all__ = ["find_contacts"]
