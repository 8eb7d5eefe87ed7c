"""Molecules and crystals: their files, other libraries' objects, bonds, styles. See docs/molecules.md."""
