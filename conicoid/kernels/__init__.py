"""Compiled kernels: from the tables of a prepared scene and arrays of rays to crossings, each with its doubt."""
