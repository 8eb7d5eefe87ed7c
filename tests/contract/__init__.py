"""The contract of every registered shape: a new one joins by its registration (see `examples.py`)."""
