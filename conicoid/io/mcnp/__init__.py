"""MCNP decks as scenes: cells, universes, lattices and macrobodies, exactly. See docs/mcnp.md.

The format is described in Los Alamos' manuals of MCNP, "Description of MCNP Input"; where those leave something open,
what is done is said in docs/mcnp.md, or it is refused.
"""
