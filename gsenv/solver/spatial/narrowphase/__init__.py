"""Contacts between shapes."""
