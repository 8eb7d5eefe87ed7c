"""Import of MCNP decks: cells, universes, lattices and macrobodies, exactly. See docs/mcnp.md.

The format is that of Los Alamos' manuals of MCNP, "Description of MCNP Input". docs/mcnp.md states how the reader
decides where those leave something open; some such inputs are refused.
"""
