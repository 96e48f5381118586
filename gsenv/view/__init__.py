"""Windows: interactive ones for worlds (`gsenv view`, `gsenv play`), and those of the mode "human" of environments."""
