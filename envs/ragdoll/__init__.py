"""GRagdoll-v0: a figure keeps its balance in 3D."""
