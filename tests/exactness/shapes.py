"""A case of `tests/oracle` (shape by name, parameters, motion steps) as an exact shape."""

from __future__ import annotations

from ..oracle.cases import Case
from .forms import chain
from .sheets import SHEETS, ExactSheet
from .solids import COMBINED, SOLIDS, Formula, moved, sphere
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


def exact_shape(*cases: Case) -> Shape:
    """The bodies that cases make in a scene: one each, or a ball each of `Spheres`."""
    references: list[Formula | ExactSheet] = []
    for case in cases:
        if case.kind == "Spheres":
            assert not case.steps, "a motion of bulk spheres rounds them"
            balls = zip(case.parameters["radii"], case.parameters["centers"], strict=True)
            references += [sphere(r, c) for r, c in balls]
        else:
            references.append(reference(case))
    return Shape(references, faces=not any(case.operands for case in cases))
