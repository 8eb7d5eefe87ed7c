"""Incremental preparation: the tables of an edited scene from those of the scene before."""
