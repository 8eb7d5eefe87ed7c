"""What every registered shape must do, whatever it is: a new one joins by existing (see `examples.py`)."""
