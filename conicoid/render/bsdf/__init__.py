"""Scattering at surfaces and in media, for Whitted's method and for light transport.

Each kind of surface is one module: diffuse.py, phong.py, conductor.py, layered.py; walls between media are in
dielectric.py. registry.py lists the kinds, dispatches to them, and has the functions
that integrators call; microfacet.py has rough mirrors and Fresnel's formulas.
"""

from __future__ import annotations
