"""Scattering at surfaces and in media, for Whitted's method and for light transport.

Each kind of surface is one module: diffuse.py, phong.py, conductor.py, layered.py; walls between media are in
dielectric.py. registry.py lists the kinds and dispatches to them, and bsdf.py is what integrators call.
"""

from __future__ import annotations
