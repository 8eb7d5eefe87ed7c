"""What every layer may use: checks of arguments, messages, safe files, pickling, settings from the environment."""
