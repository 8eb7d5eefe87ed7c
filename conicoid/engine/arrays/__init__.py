"""Kernels over arrays of rays: which route a ray takes, and where its hit is written."""
