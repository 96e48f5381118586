"""Run time against error: gsenv beside Box2D and pymunk, on scenes with known answers.

    python -m benchmarks.accuracy [--quick] [--only 14:10 ...] [--engine gsenv ...] [--fresh]
"""
