"""Random bodies of every kind: leaves of all shapes, Booleans of them, sheets that are clipped, chains of motions."""

import numpy as np

import conicoid as co
from conicoid.geometry.bulk import Bulk
from conicoid.geometry.registry import REGISTRY

from ..contract.examples import examples_of
from ..reference.random_items import SOLIDS as KINDS, motion, plain

NAMES = [
    n
    for n in sorted(REGISTRY)
    if n not in ("Union", "Intersection", "Difference", "Complement", "Painted", "ClippedSheet")
    and not issubclass(REGISTRY[n], Bulk)
]
EXAMPLES = [shape for name in NAMES for shape in examples_of(name)]
SOLIDS = [shape for shape in EXAMPLES if not shape.is_sheet]
SHEETS = [shape for shape in EXAMPLES if shape.is_sheet]
RED = co.matte((0.9, 0.1, 0.1))


def random_leaf(rng: np.random.Generator):
    """Return an example of the contract suite, or a shape of small whole numbers."""
    if rng.random() < 0.4:
        return SOLIDS[int(rng.integers(len(SOLIDS)))]
    return plain(rng, str(rng.choice(KINDS))).shape(co)


def moved(rng: np.random.Generator, shape, most: int):
    """Return a shape moved by up to `most` steps."""
    for verb, *arguments in motion(rng) if rng.integers(most + 1) else ():
        shape = getattr(shape, verb)(*arguments)
    return shape


def random_solid(rng: np.random.Generator, depth: int):
    """Return a tree of at most some levels. Operands may be equal, so that faces coincide."""
    if depth == 0 or rng.random() < 0.15:
        return moved(rng, random_leaf(rng), 1)
    one, other = random_solid(rng, depth - 1), random_solid(rng, depth - 1)
    kind = int(rng.integers(8))
    if kind == 0:
        return ~one
    if kind == 1:
        other = moved(rng, one, 1)
    if kind == 2:
        other = other.painted(RED)
    solid = (one | other, one & other, one - other)[int(rng.integers(3))]
    return moved(rng, solid, 1)


def random_body(rng: np.random.Generator):
    """Return a solid, and now and then a sheet or a clipped one."""
    if rng.random() < 0.15:
        sheet = moved(rng, SHEETS[int(rng.integers(len(SHEETS)))], 1)
        solid = random_solid(rng, 1)
        return (sheet, sheet & solid, sheet - solid)[int(rng.integers(3))]
    return random_solid(rng, int(rng.integers(1, 4)))
