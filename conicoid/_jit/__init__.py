"""Compiled functions: their decorators, the machine code of the package, and the compiler."""
