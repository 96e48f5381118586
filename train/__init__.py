"""Experiments, installed as `gsenv.train`: one script each, with its settings on top."""
