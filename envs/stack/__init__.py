"""GStack-v0: a gripper builds a tower of blocks in 2D."""
