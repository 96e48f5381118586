"""GRagdoll2D-v0: a planar figure keeps its balance in 2D."""
