"""How light is gathered along a ray: one integrator, one file, each a `radiance` for kernels."""
