"""Data files, installed as `gsenv.assets`; read them with `importlib.resources.files("gsenv.assets")`."""
