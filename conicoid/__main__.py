"""``python -m conicoid`` is the command ``conicoid``."""

from .cli import main

main()
