"""Compiled functions: their decorators, the machine code of the package, the compiler, and its cache on disk."""
