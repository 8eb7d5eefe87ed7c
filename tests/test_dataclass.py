"""The package's `dataclass` against the standard library's: a class by either behaves alike."""

import copy
import dataclasses
import inspect
import pickle
import re
import sys
import types
from pathlib import Path

import pytest

import conicoid
from conicoid._util.records import dataclass

from .messages import outcome

SOURCE = """
from __future__ import annotations
from dataclasses import field
from typing import ClassVar

@dataclass
class Plain:
    x: float
    y: int = 3
    made: list = field(default_factory=list)
    later: float = field(init=False)
    hidden: float = field(default=1.0, repr=False, compare=False)
    count: ClassVar[int] = 0
    def __post_init__(self):
        self.later = self.x + 1

@dataclass(frozen=True)
class Frozen:
    x: float
    y: tuple = ()
    z: float = field(default=0.0, kw_only=True)

@dataclass(frozen=True)
class Derived(Frozen):
    y: tuple = (1,)
    w: float = 2.0

@dataclass(frozen=True)
class Own:
    x: float
    def __eq__(self, other): return True
    def __repr__(self): return "own"

@dataclass(frozen=True)
class Hashed:
    x: float
    def __hash__(self): return 7

@dataclass(frozen=True, eq=False)
class Identical:
    x: float

@dataclass(eq=False, repr=False)
class Bare:
    x: float

@dataclass(frozen=True)
class Nothing:
    pass

@dataclass(frozen=True)
class Recursive:
    parts: list
"""
MODULES = {}
for name, decorator in (("ours", dataclass), ("standards", dataclasses.dataclass)):
    MODULES[name] = types.ModuleType(name)
    sys.modules[name] = MODULES[name]
    vars(MODULES[name])["dataclass"] = decorator
    exec(SOURCE, vars(MODULES[name]))
CALLS = [
    ("Plain", (1.5,), {}), ("Plain", (1.5, 4, [2]), dict(hidden=5.0)), ("Plain", (), {}), ("Plain", (1.5,), dict(later=2.0)),
    ("Frozen", (1.0,), {}), ("Frozen", (1.0, (2,)), dict(z=3.0)), ("Frozen", (1.0, (2,), 3.0), {}), ("Derived", (1.0,), dict(z=1.0)),
    ("Frozen", ([],), {}), ("Own", (1.0,), {}), ("Hashed", (1.0,), {}), ("Identical", (1.0,), {}), ("Bare", (1.0,), {}),
    ("Nothing", (), {}), ("Nothing", (1,), {}), ("Recursive", ([],), {}),
]  # fmt: skip


@pytest.mark.parametrize("call", CALLS, ids=str)
def test_classes_of_both_decorators_behave_alike(call):
    name, _, named = call
    values = []
    for module in MODULES.values():
        arguments = copy.deepcopy(call[1])
        kind = getattr(module, name)
        one, two = (outcome(lambda: kind(*arguments, **named)) for _ in range(2))  # noqa: B023
        found = [str(inspect.signature(kind)), kind.__match_args__, [f.name for f in dataclasses.fields(kind)]]
        found += [sorted(vars(kind)), repr(kind.__dataclass_params__)]
        found += [vars(kind)[method].__name__ for method in ("__eq__", "__hash__") if callable(vars(kind).get(method))]
        if not isinstance(one, kind):
            values.append((found, one))
            continue
        if name == "Recursive":
            one.parts.append(one)
            values.append(repr(one))
            continue
        found += [one == two, outcome(lambda: hash(one) == hash(two)), outcome(lambda: len({one, two}))]  # noqa: B023
        found += [one == 1, outcome(lambda: dataclasses.asdict(one))]  # noqa: B023
        changed = outcome(lambda: dataclasses.replace(one, x=9.0))  # noqa: B023
        found += [
            repr(changed) if name != "Bare" else vars(changed),
            vars(pickle.loads(pickle.dumps(two))) == vars(two),
        ]
        found += [repr(one) if name != "Bare" else None]
        for act in (lambda: setattr(one, "x", 5.0), lambda: delattr(one, "x"), lambda: setattr(one, "other", 1)):  # noqa: B023
            found.append(outcome(act))
        values.append(found)
    assert values[0] == values[1]


@pytest.mark.parametrize(
    ("base", "decorator"), [(MODULES["ours"].Frozen, dataclasses.dataclass), (MODULES["standards"].Frozen, dataclass)]
)
def test_both_decorators_take_classes_of_the_other(base, decorator):

    @decorator(frozen=True)
    class Child(base):
        more: float = 1.0

    class Grandchild(Child):
        pass

    grandchild = Grandchild(1.0)
    grandchild.new = 5
    del grandchild.new
    with pytest.raises(dataclasses.FrozenInstanceError):
        grandchild.x = 5.0
    assert Child(1.0, z=2.0) == Child(1.0, z=2.0)
    assert [field.name for field in dataclasses.fields(Child)] == ["x", "y", "z", "more"]
    with pytest.raises(dataclasses.FrozenInstanceError):
        Child(1.0).more = 2.0


def test_the_package_uses_the_standards_decorator_only_for_slots_and_order():
    folder = Path(conicoid.__file__).parent
    ours = r"@dataclass\b(?!.*(slots|order)=True)"
    for path in folder.rglob("*.py"):
        text = path.read_text()
        if re.search(rf"^\s*{ours}", text, re.MULTILINE):
            assert re.search(r"^from \.+_util\.records import [(\w\s,]*\bdataclass\b", text, re.MULTILINE), path
        assert not re.search(r"@dataclasses\.dataclass\b(?!.*(slots|order)=True)", text), path
