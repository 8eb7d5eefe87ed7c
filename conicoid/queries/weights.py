"""What path lengths are summed by, and with which weights: values by body, by material, or kept by materials."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from .._util.arrays import FloatArray
from .._util.hints import closest_name, describe_names
from .._util.validation import format_value, real_array
from ..materials.properties import Properties

BODY, MATERIAL = "body", "material"
BY_BODY = "names are those of materials, and values by body are an array in the order of their numbers"
_MOST = 5  # materials that a message names

DistinctMaterials = Sequence[tuple[Any, bool]]
"""The materials of a scene's bodies, and whether any solid has them (see `Labels.distinct`)."""


@dataclass(frozen=True)
class Weights:
    """A weight for each body or material, (n,), or several, (n, energies)."""

    by: str
    values: FloatArray

    @property
    def shape(self) -> tuple[int, ...]:
        """What follows the rays' shape in an integral."""
        return self.values.shape[1:]


def check_by(owner: str, by: Any) -> str:
    """By what lengths are summed, "body" or "material"; a ValueError otherwise."""
    if not isinstance(by, str) or by not in (BODY, MATERIAL):
        close = closest_name(by, (BODY, MATERIAL)) if isinstance(by, str) else ""
        meant = f" (did you mean {close!r}?)" if close else ""
        raise ValueError(f"{owner}: by must be 'body' or 'material', got {format_value(by)}{meant}")
    return by


def weights_of(values: Any, otherwise: Any, bodies: int, distinct: DistinctMaterials) -> Weights:
    """Weights from an array (bodies,) or (bodies, energies), values by the name of the material, or a property's name.

    `otherwise` is for materials that have no such value; without it they are a ValueError, if any solid has them.
    """
    if isinstance(values, str):
        hint = _other_properties(values, distinct)
        if otherwise is not None and _no_material_has(values, distinct):
            told = hint or "; properties: none has any"
            raise ValueError(f"line_integral: values: no material has a property {format_value(values)}{told}")
        what = f"property {format_value(values)}"
        return _weights_by_name(lambda material: _property(material, values), otherwise, distinct, what, hint)
    if isinstance(values, Mapping):
        given = dict(_entries(values, distinct))
        return _weights_by_name(lambda material: given.get(material and material.name), otherwise, distinct, "value")
    if otherwise is not None:
        raise ValueError("line_integral: otherwise goes with values by name, not with an array for all bodies")
    expected = f"an array ({bodies},) or ({bodies}, energies), a mapping from materials' names, or a property's name"
    array = real_array("line_integral", "values", values, expected)
    if array.ndim not in (1, 2) or len(array) != bodies:
        hint = f"; one number for all is np.full({bodies}, ...)" if array.ndim == 0 else ""
        raise ValueError(
            f"line_integral: values must have shape ({bodies},) or ({bodies}, energies), got {array.shape}{hint}"
        )
    return Weights(BODY, array)


def _other_properties(name: str, distinct: DistinctMaterials) -> str:
    """Where no material has a property: what they have, for a message."""
    known = dict.fromkeys(key for material, _ in distinct if material is not None for key in material.properties)
    return f"; {describe_names(name, 'properties', list(known))}" if known and name not in known else ""


def _no_material_has(name: str, distinct: DistinctMaterials) -> bool:
    """Whether there are solids, and no material has a property."""
    return any(of_solids for _, of_solids in distinct) and not any(
        material is not None and name in material.properties for material, _ in distinct
    )


def _property(material: Any, name: str) -> Any:
    """A property of a material as numbers; None for a material without."""
    found: Any = None if material is None else material.properties.get(name)
    if isinstance(found, (str, tuple, Properties)) or (found is not None and np.ndim(found) > 1):
        told = f"property {name!r} of {_material_label(material)}"
        raise ValueError(
            f"line_integral: values: {told} must be a number or an array (energies,), got {format_value(found)}"
        )
    return found


def _entries(values: Mapping[Any, Any], distinct: DistinctMaterials) -> Iterator[tuple[str, Any]]:
    """Name and value, checked."""
    known = dict.fromkeys(material.name for material, _ in distinct if material is not None and material.name)
    for name, value in values.items():
        if name not in known:
            told = describe_names(name, "materials", list(known)) + "; " + BY_BODY
            raise ValueError(f"line_integral: values: no material is called {format_value(name)}; {told}")
        yield name, _numbers(f"values[{name!r}]", value)


def _numbers(field: str, value: Any) -> FloatArray:
    array = real_array("line_integral", field, value, "a number or an array (energies,)")
    if array.ndim > 1:
        raise ValueError(f"line_integral: {field} must be a number or an array (energies,), got shape {array.shape}")
    return array


def _weights_by_name(
    value_of: Callable[[Any], Any], otherwise: Any, distinct: DistinctMaterials, what: str, hint: str = ""
) -> Weights:
    """Weights by material. One number for a material stands for as many as others have."""
    rest = None if otherwise is None else _numbers("otherwise", otherwise)
    found = [value_of(material) for material, _ in distinct]
    missing = [m for (m, of_solids), value in zip(distinct, found, strict=True) if value is None and of_solids]
    if missing and rest is None:
        more = f" and {len(missing) - _MOST} more" if len(missing) > _MOST else ""
        named = ", ".join(_material_label(material) for material in missing[:_MOST]) + more
        raise ValueError(
            f"line_integral: values: no {what} for {named}; otherwise=0 (or another value) stands for it{hint}"
        )
    rows = [np.asarray(value if value is not None else 0.0 if rest is None else rest, np.float64) for value in found]
    lengths = {len(row): material for row, (material, _) in zip(rows, distinct, strict=True) if row.ndim}
    if len(lengths) > 1:
        told = " and ".join(
            f"{length} for {_material_label(material)}" for length, material in list(lengths.items())[:2]
        )
        raise ValueError(f"line_integral: values must be as many for each material, got {told}")
    shape = (len(rows), *lengths)
    table = np.zeros(shape)
    for place, row in enumerate(rows):
        table[place] = row
    return Weights(MATERIAL, table)


def _material_label(material: Any) -> str:
    if material is None:
        return "bodies without a material"
    return (
        f"material {material.name!r}"
        if material.name
        else f"a material without a name, color {format_value(material.color)}"
    )
