"""One function of the shaders against the Python function that it mirrors, and when their answers agree.

The shaders round where Python does not, so their answer need only be right for inputs a little beside the given ones (a
backward error). Python itself finds the tolerance: it evaluates eight random shifts of every input and coefficient, by
up to 16 roundings of single precision of its size. A number must be as near to Python's as four times the farthest of
these answers. A truth value or a whole number must be Python's unless these answers differ among each other. Most
inputs must be decided that way, or the comparison would show nothing. Inputs that are short binary fractions are not
shifted, because ties and contacts are decided without rounding. Their whole numbers must be equal always, and others
but for the rounding of a few roots and quotients.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from conicoid._jit.decorators import helper, kernel
from conicoid.kernels.body.scratch import new_scratch

from .worlds import ROUNDING, SHIFT, Scene

FAR = 1e30
"""The shaders' infinity."""
SPREAD = 4.0
"""Eight random shifts reach a quarter of the worst shift's effect, or more."""
ALONE, VECTOR = "s", "v"


@dataclass(frozen=True)
class Case:
    """A comparison. `python(world, scratch, input, answers)` has the results of `glsl`.

    `inputs(scene, rng)` are records of four float32, (n, records, 4). `shifts` has for each of a record's four numbers
    "v", a part of a vector, "s", a number by itself, or "-", never shifted. `whole` is the count of the first answers
    that are whole numbers, and `decided` the share of the inputs that must be decided. `agrees(python, glsl)` replaces
    the comparison.
    """

    glsl: str
    python: Callable[..., None]
    answers: int
    inputs: Callable[[Scene, Any], Any]
    shifts: tuple[str, ...] = ()
    whole: int = 0
    decided: float = 0.9
    exact_inputs: Callable[[Scene, Any], Any] | None = None
    agrees: Callable[[Any, Any], Any] | None = None
    view: Any = None
    sizes: Any = None


def evaluator(cases: dict[str, Case]) -> Callable[..., Any]:
    """Return evaluate(name, world, inputs), the answers of a case's Python.

    All cases are in one kernel, so that their callees compile once.
    """
    choose = _none
    for number, case in enumerate(cases.values()):
        choose = _or(number, helper(case.python), choose)
    numbers = {name: number for number, name in enumerate(cases)}

    @kernel()
    def rows(number, world, inputs, answers):
        scratch = new_scratch(world.geometry)
        for i in range(len(inputs)):
            choose(number, world, scratch, inputs[i], answers[i])

    def evaluate(name: str, world: Any, inputs: Any) -> Any:
        answers = np.zeros((len(inputs), cases[name].answers))
        rows(numbers[name], world, np.ascontiguousarray(inputs, float).reshape(len(inputs), -1), answers)
        return np.clip(answers, -FAR, FAR)

    return evaluate


@helper
def _none(number, world, scratch, x, answers):
    pass


def _or(mine: int, python: Any, others: Any) -> Any:
    @helper
    def choose(number, world, scratch, x, answers):
        if number == mine:
            python(world, scratch, x, answers)
        else:
            others(number, world, scratch, x, answers)

    return choose


def shifted(inputs: Any, shifts: tuple[str, ...], rng: Any) -> Any:
    """Return inputs beside the given ones."""
    kinds = np.array([list(record) for record in shifts])
    size = np.abs(inputs) * (kinds == ALONE)
    longest = np.where(kinds == VECTOR, np.abs(inputs), 0.0).max(axis=-1, keepdims=True)
    size += longest * (kinds == VECTOR)
    size = np.where(size < 1e29, size, 0.0)  # infinity is exact
    return inputs + SHIFT * rng.uniform(-1, 1, inputs.shape) * size


def disagreements(
    name: str, case: Case, scene: Scene, inputs: Any, found: Any, evaluate: Any
) -> tuple[Any, Any, float]:
    """Return (indices of inputs with different answers, Python's answers, share of decided inputs)."""
    exact = inputs.astype(float)
    expected = evaluate(name, scene.python, exact)
    if case.agrees is not None:
        return np.flatnonzero(~case.agrees(expected, found)), expected, 1.0
    rng = np.random.default_rng(7)
    around = [evaluate(name, world, shifted(exact, case.shifts, rng)) for world in scene.shifted]
    same = [(answers[:, : case.whole] == expected[:, : case.whole]).all(axis=1) for answers in around]
    spread = np.max([np.abs(answers - expected) for answers in around], axis=0, initial=0.0)
    if around:
        allowed = SPREAD * spread + SHIFT * np.abs(expected) + 1e-30
    else:
        finite = np.where(np.abs(expected) < FAR, np.abs(expected), 0.0)
        allowed = 8 * ROUNDING * np.maximum(finite.max(axis=1, keepdims=True, initial=1.0), np.abs(expected))
    close = np.abs(found - expected) <= allowed
    good = (found == expected)[:, : case.whole].all(axis=1) & close[:, case.whole :].all(axis=1)
    sharp = (allowed <= 1e-3 * (1 + np.abs(expected)))[:, case.whole :].all(axis=1)
    steady = np.all(same, axis=0) if around else np.ones(len(exact), bool)
    return np.flatnonzero(steady & ~good), expected, float((steady & sharp).mean())
