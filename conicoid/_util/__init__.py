"""Helpers for every layer: checks of arguments, messages, safe files, pickling, settings from the environment."""
