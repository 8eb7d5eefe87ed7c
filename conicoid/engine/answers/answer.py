"""What answers of a scene have in common: names and materials of the bodies in them, and a life without the scene."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from ...shapes.calls import explained_methods
from ...shapes.carried import restore
from ...shapes.labels import Labels
from .no_array import NoArray
from .no_names import numbered
from .objects import objects

if TYPE_CHECKING:
    from ..prepared import Prepared


class NoScene:
    """In place of the scene of an answer that has been taken from it."""

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        raise ValueError("this answer was detached from its scene, or pickled, and holds nothing that can tell")


NO_SCENE: Any = NoScene()


_OF_SCENE = "_scene", "_met", "_moving"
"""What an answer keeps only as long as it has its scene: it, and what derivatives have found of its walls."""


@explained_methods
class Answer(NoArray):
    """Hits, spans or crossings: read-only, and equal where all their fields are.

    Pickled or `detached`, they keep all their fields and do not keep the scene.
    """

    __hash__ = None  # type: ignore[assignment]
    _scene: Prepared
    _views: ClassVar[tuple[str, ...]] = ()
    """Fields that are other attributes in another form: these are not kept twice."""

    @cached_property
    def _home(self) -> bytes:
        """Which scene's surfaces the numbers belong to (`Prepared.key`)."""
        return self._scene.key

    @cached_property
    def _labels(self) -> Labels:
        """Names and materials of the scene's bodies."""
        return self._scene.labels

    @property
    def _numbers(self) -> Any:
        """The bodies that `name` and `material` are of."""
        return self.body  # type: ignore[attr-defined]

    @property
    def name(self) -> Any:
        """The name of each body, objects of the shape of `body`: a text, or None for a body without and for a miss."""
        return objects(self._labels.names_of(self._numbers), None if self._scene is NO_SCENE else self._labels)

    @property
    def material(self) -> Any:
        """The material of each body, objects of the shape of `body`: as `scene.body(number).material`, None for a miss.

        None is also that of a body without, which is the default one. The paint of single faces is not included.
        """
        return objects(self._labels.materials_of(self._numbers))

    def detached(self) -> Self:
        """The same without the scene, which then need not be kept: all fields are worked out, and stay.

        Pickles are like that. Rays spawned from them still know their surface, in any scene with the same surfaces.
        """
        result = object.__new__(type(self))
        result.__setstate__(self.__getstate__())
        return result

    if not TYPE_CHECKING:  # else checkers would let any name be set

        def __setattr__(self, name: str, value: Any) -> None:
            raise AttributeError(f"{type(self).__name__} are read-only: {name} cannot be set")

        def __delattr__(self, name: str) -> None:
            raise AttributeError(f"{type(self).__name__} are read-only: {name} cannot be deleted")

    def __eq__(self, other: object) -> bool:
        """Whether all fields are equal, NaN counting as equal to NaN; never an array."""
        if type(other) is not type(self):
            return NotImplemented
        fields = (*self._fields(), *(["_rays"] if "_rays" in vars(self) else []))
        return all(_same(getattr(self, field), getattr(other, field)) for field in fields)

    def _fields(self) -> list[str]:
        """The public attributes and properties."""
        kind = type(self)
        worked_out = (f for f in dir(kind) if isinstance(getattr(kind, f), (property, cached_property)))
        return [field for field in {**dict.fromkeys(worked_out), **vars(self)} if not field.startswith("_")]

    def __getstate__(self) -> dict[str, Any]:
        for field in self._fields():
            getattr(self, field)
        state = {name: value for name, value in vars(self).items() if name not in (*_OF_SCENE, *self._views)}
        return {**state, "_home": self._home, "_labels": self._labels.of_only(self._numbers)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        restore(self, state)
        vars(self).update(numbered(vars(self)), _scene=NO_SCENE)

    def __copy__(self) -> Self:
        result = object.__new__(type(self))
        vars(result).update(vars(self))
        return result

    def __deepcopy__(self, memo: Any) -> Self:
        del memo  # all of it is read-only
        return self.__copy__()


def _same(one: Any, other: Any) -> bool:
    """Are two fields equal, NaN counting as equal to NaN?"""
    if isinstance(one, np.ndarray | np.generic):
        return np.array_equal(one, other, equal_nan=one.dtype.kind == "f")
    return bool(one == other)
