"""The compiled scene as structured arrays: Model, State, scratch."""
