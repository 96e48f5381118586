"""The public classes of a running simulation: World, Options, Parameters."""
