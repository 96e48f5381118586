"""Benchmarks of gsenv: accuracy, speed, stability. ``python -m benchmarks`` lists them, registry.py names them."""
