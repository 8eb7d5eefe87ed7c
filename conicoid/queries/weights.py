"""Weights of line integrals: by body, by the name of a material, or a property that materials have."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from .._util.arrays import FloatArray
from .._util.records import dataclass
from .._util.text import check_choice, describe_names
from .._util.validation import format_value, real_array
from ..materials.material import Properties

LineValues: TypeAlias = "npt.ArrayLike | Mapping[str, npt.ArrayLike] | str"
"""Values of line integrals: an array by body, a mapping from names of materials, or the name of a property."""

BODY, MATERIAL = "body", "material"
_MOST = 5  # materials that a message names

DistinctMaterials = Sequence[tuple[Any, bool]]
"""The different materials of a scene's bodies, each with whether any solid has it (see `Labels.distinct`)."""


@dataclass(frozen=True)
class Weights:
    """Weights (n,) or (n, energies), one row for each body or for each material (`by`)."""

    by: str
    values: FloatArray

    @property
    def shape(self) -> tuple[int, ...]:
        """The axes of an integral after those of the rays: () or (energies,)."""
        return self.values.shape[1:]


def check_by(owner: str, by: Any) -> str:
    """Return `by`. Raise ValueError unless it is "body" or "material"."""
    return check_choice(owner, "by", by, (BODY, MATERIAL))


def weights_of(values: Any, otherwise: Any, bodies: int, distinct: DistinctMaterials) -> Weights:
    """Return the weights of an argument `values`.

    values: an array (bodies,) or (bodies, energies), a mapping from names of materials, or the name of a property.
    otherwise: the value for materials without one; if it is None, raise ValueError for such a material of a solid.
    """
    if isinstance(values, str):
        hint = _other_properties(values, distinct)
        if otherwise is not None and _no_material_has(values, distinct):
            others = hint or "; properties: none has any"
            raise ValueError(f"line_integral: values: no material has a property {format_value(values)}{others}")
        label = f"property {format_value(values)}"
        return _weights_by_name(lambda material: _property(material, values), otherwise, distinct, label, hint)
    if isinstance(values, Mapping):
        by_name = dict(_entries(values, distinct))
        return _weights_by_name(lambda material: by_name.get(material and material.name), otherwise, distinct, "value")
    if otherwise is not None:
        raise ValueError("line_integral: otherwise goes with values by name, not with an array for all bodies")
    expected = f"an array ({bodies},) or ({bodies}, energies), a mapping from materials' names, or a property's name"
    array = real_array("line_integral", "values", values, expected)
    if array.ndim not in (1, 2) or len(array) != bodies:
        raise ValueError(
            f"line_integral: values must have shape ({bodies},) or ({bodies}, energies), got {array.shape}"
        )
    return Weights(BODY, array)


def _other_properties(name: str, distinct: DistinctMaterials) -> str:
    """Return a hint with the properties that materials have, "" if one of them is `name` or there are none."""
    names = dict.fromkeys(key for material, _ in distinct if material is not None for key in material.properties)
    return f"; {describe_names(name, 'properties', list(names))}" if names and name not in names else ""


def _no_material_has(name: str, distinct: DistinctMaterials) -> bool:
    """Return True if there are solids and no material has the property `name`."""
    return any(of_solids for _, of_solids in distinct) and not any(
        material is not None and name in material.properties for material, _ in distinct
    )


def _property(material: Any, name: str) -> Any:
    """Return a property of a material as a number or array; None for a material without it."""
    value: Any = None if material is None else material.properties.get(name)
    if isinstance(value, (str, tuple, Properties)) or (value is not None and np.ndim(value) > 1):
        label = f"property {name!r} of {_material_label(material)}"
        raise ValueError(
            f"line_integral: values: {label} must be a number or an array (energies,), got {format_value(value)}"
        )
    return value


def _entries(values: Mapping[Any, Any], distinct: DistinctMaterials) -> Iterator[tuple[str, Any]]:
    """Yield name and value of each entry of a mapping. Raise ValueError for unknown names and for other values."""
    names = dict.fromkeys(material.name for material, _ in distinct if material is not None and material.name)
    for name, value in values.items():
        if name not in names:
            named = describe_names(name, "materials", list(names))
            raise ValueError(f"line_integral: values: no material is called {format_value(name)}; {named}")
        yield name, _numbers(f"values[{name!r}]", value)


def _numbers(field: str, value: Any) -> FloatArray:
    """Return a value as an array () or (energies,). Raise ValueError, naming the field, for anything else."""
    array = real_array("line_integral", field, value, "a number or an array (energies,)")
    if array.ndim > 1:
        raise ValueError(f"line_integral: {field} must be a number or an array (energies,), got shape {array.shape}")
    return array


def _weights_by_name(
    value_of: Callable[[Any], Any], otherwise: Any, distinct: DistinctMaterials, label: str, hint: str = ""
) -> Weights:
    """Return weights by material. A single number of a material stands for all energies that others have.

    label: the kind of the value, for messages.
    """
    rest = None if otherwise is None else _numbers("otherwise", otherwise)
    found = [value_of(material) for material, _ in distinct]
    missing = [m for (m, of_solids), value in zip(distinct, found, strict=True) if value is None and of_solids]
    if missing and rest is None:
        more = f" and {len(missing) - _MOST} more" if len(missing) > _MOST else ""
        named = ", ".join(_material_label(material) for material in missing[:_MOST]) + more
        raise ValueError(
            f"line_integral: values: no {label} for {named}; otherwise=0 (or another value) stands for it{hint}"
        )
    rows = [np.asarray(value if value is not None else 0.0 if rest is None else rest, np.float64) for value in found]
    lengths = {len(row): material for row, (material, _) in zip(rows, distinct, strict=True) if row.ndim}
    if len(lengths) > 1:
        counts = " and ".join(
            f"{length} for {_material_label(material)}" for length, material in list(lengths.items())[:2]
        )
        raise ValueError(f"line_integral: values must be as many for each material, got {counts}")
    shape = (len(rows), *lengths)
    table = np.zeros(shape)
    for place, row in enumerate(rows):
        table[place] = row
    return Weights(MATERIAL, table)


def _material_label(material: Any) -> str:
    """Return a material's name, or its color if it has none, for messages."""
    if material is None:
        return "bodies without a material"
    return (
        f"material {material.name!r}"
        if material.name
        else f"a material without a name, color {format_value(material.color)}"
    )
