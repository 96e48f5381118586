"""GCar-v0: a car drives over hills and obstacles in 2D."""
