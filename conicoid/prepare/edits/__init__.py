"""Incremental preparation: the tables of an edited scene from those of the scene before.

User: loops that move one body among many; factor over preparing afresh: 12 for 10,000 boxes, 20 for 10,000 Booleans
(processor time, one thread, 2026-11-28); 110 for a core of 400,000 pins (`lattice_edit.py`).
"""
