"""Conicoid's own scene files, YAML and JSON."""
