"""Conicoid's own scene files: YAML 1.2 and JSON."""
