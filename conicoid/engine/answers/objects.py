"""Names and materials of answers: arrays of objects, of which `np.unique` can tell the different ones.

NumPy sorts for that, and neither None, the name of a miss, nor a material can be sorted. Here names are, None comes
last, and materials come in the order in which they first appear. Whatever is computed with them is plain.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ...shapes.labels import Labels
from ...shapes.suggestion import known_names
from ...shapes.validate import shown
from ...shapes.warned import warn

_UNIQUE = ("unique", "unique_values", "unique_counts", "unique_inverse", "unique_all")


_ORDERS = ("sort", "argsort", "lexsort", "min", "max", "amin", "amax", "searchsorted")
_MOST_NAMES = 100_000


class Objects(np.ndarray[Any, Any]):
    """An array of objects, most of them equal to others in it.

    Names know those of the whole scene: one that there is not equals none, and a warning tells of it.
    """

    labels: Labels | None = None

    def __eq__(self, other: object) -> Any:
        found = super().__eq__(other)
        if isinstance(other, str) and self.labels is not None:
            self._tell_unknown(other, self.labels)
        return found

    def __ne__(self, other: object) -> Any:
        found = super().__ne__(other)
        if isinstance(other, str) and self.labels is not None:
            self._tell_unknown(other, self.labels)
        return found

    __hash__ = None

    def _tell_unknown(self, name: str, labels: Labels) -> None:
        if type(labels) is Labels and len(labels.names) <= _MOST_NAMES and name not in labels.names:
            known = [one for one in labels.names if one is not None]
            warn(f"no body is called {shown(name)}, which so equals none of these; {known_names(name, 'names', known)}")

    def __array_wrap__(self, array: Any, context: Any = None, return_scalar: bool = False) -> Any:
        del context
        return array[()] if return_scalar or array.ndim == 0 else np.asarray(array)

    def __array_function__(self, function: Any, types: Any, args: Any, kwargs: Any) -> Any:
        if function.__name__ in _UNIQUE and args and args[0] is self and self.dtype == object:
            return _unique(function, np.asarray(self), args[1:], kwargs)
        if function.__name__ in _ORDERS and self.dtype == object and any(value is None for value in self.flat):
            raise TypeError(
                f"{function.__name__}: a miss has no name and no material, and None has no order: "
                f"np.unique(...) has the different ones, and hits[hits.hit] no misses"
            )
        return super().__array_function__(function, types, args, kwargs)

    def __reduce_ex__(self, protocol: Any) -> Any:
        return np.asarray(self).__reduce_ex__(protocol)

    def __repr__(self) -> str:
        return repr(np.asarray(self))


def objects(values: Any, labels: Labels | None = None) -> Any:
    """The same, read-only if it is an array: one of which `np.unique` can tell the different ones.

    labels: of names, those of the whole scene.
    """
    if not isinstance(values, np.ndarray):
        return values
    values.flags.writeable = False
    found = values.view(Objects)
    found.labels = labels
    return found


def _unique(function: Any, values: Any, args: Any, kwargs: Any) -> Any:
    """NumPy's function of the places of values among the different ones."""
    by_identity = {id(value): value for value in values.ravel().tolist()}  # comparing materials takes longer
    different = list(dict.fromkeys(by_identity.values()))
    texts = sorted(value for value in different if isinstance(value, str))
    others = [value for value in different if value is not None and not isinstance(value, str)]
    ordered = [*texts, *others, *([None] if None in by_identity.values() else [])]
    places = {value: place for place, value in enumerate(ordered)}
    place_of = {one: places[value] for one, value in by_identity.items()}
    codes = np.array([place_of[id(value)] for value in values.ravel().tolist()], np.int64).reshape(values.shape)
    table = np.empty(len(ordered), object)
    table[:] = ordered
    found = function(codes, *args, **kwargs)
    if isinstance(found, np.ndarray):
        return table[found]
    kept = [table[found[0]], *found[1:]]
    return type(found)(*kept) if hasattr(found, "_fields") else tuple(kept)
