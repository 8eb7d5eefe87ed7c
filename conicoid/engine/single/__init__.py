"""The route of single rays."""
