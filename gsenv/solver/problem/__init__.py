"""The solver without bodies: ``Problem`` and ``solve``."""
