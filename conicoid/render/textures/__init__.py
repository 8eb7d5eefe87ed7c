"""Textures in kernels: records, texels, and colours at a point."""
