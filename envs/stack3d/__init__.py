"""GStack3D-v0: a gripper builds a tower of blocks in 3D."""
