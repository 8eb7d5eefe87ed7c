"""Queries on a prepared scene."""
