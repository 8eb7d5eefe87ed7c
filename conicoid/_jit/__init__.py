"""The compiler: Numba's decorators as the engine uses them, kernels on disk."""
