"""A case of `tests/oracle` (shape by name, parameters, motion steps) as an exact shape."""

from __future__ import annotations

from ..oracle.cases import Case
from .forms import Form, chain
from .sheets import SHEETS, ExactSheet
from .solids import COMBINED, SOLIDS, Formula, mapped, moved, sphere
from .traced import Shape


def reference(case: Case) -> Formula | ExactSheet:
    """The formula or sheet of a case, in the world."""
    motion = chain(case.steps)
    if case.kind == "ClippedSheet":
        base, solid = (reference(operand) for operand in case.operands)
        assert isinstance(base, ExactSheet)
        assert isinstance(solid, tuple)
        found: Formula | ExactSheet = base.clipped(("not", solid) if case.parameters["keep"] == "outside" else solid)
    elif case.operands:
        found = COMBINED[case.kind](*(reference(operand) for operand in case.operands))
    elif case.kind in SHEETS:
        found = SHEETS[case.kind](**case.parameters)
    else:
        found = SOLIDS[case.kind](**case.parameters)
    if not case.steps:
        return found
    return found.moved(motion) if isinstance(found, ExactSheet) else moved(found, motion)


def bodies(case: Case) -> list[Shape]:
    """The bodies that a case makes in a scene: one, or a ball each of `Spheres`."""
    if case.kind == "Spheres":
        return [Shape(sphere(r, c)) for r, c in zip(case.parameters["radii"], case.parameters["centers"], strict=True)]
    return [Shape(reference(case), faces=not case.operands)]


def renumbered(formula: Formula, face: int) -> Formula:
    return mapped(formula, lambda f: Form(f.k, face, f.exact, f.flat))
