"""Training, installed as `gsenv.train`: one script per algorithm, with its settings at the top."""
