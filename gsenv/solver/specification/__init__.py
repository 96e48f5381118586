"""The description of a scene by its user: bodies, joints, sensors; and its compilation to a Model."""
