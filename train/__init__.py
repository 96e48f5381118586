"""Training, installed as `gsenv.train`: PPO with its settings in `ppo.py`, what it is made of in the other modules."""
