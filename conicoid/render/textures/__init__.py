"""Textures as kernels know them: records, texels, and the colours at a point."""
