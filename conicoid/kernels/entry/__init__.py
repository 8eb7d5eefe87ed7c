"""Kernels over arrays of rays: which route a ray takes, and where its hit is written."""

from __future__ import annotations


# The route of single rays: those in doubt or beside others that see something else, and those of integrators.
#
# A lone ray of a query goes as a packet whose other lanes are idle.
