"""tower_v0: two grippers build one tower together in 2D."""
