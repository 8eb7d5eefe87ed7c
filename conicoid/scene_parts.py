"""What a scene is made of, as a user hands it over: bodies and a camera."""

from __future__ import annotations

import dataclasses
import operator
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from .shapes.base import Shape, Solid
from .shapes.body import Body
from .shapes.bulk import Bulk
from .shapes.spheres import Spheres
from .shapes.suggestion import known_names
from .shapes.validate import shown, what


def as_bodies(items: Any) -> tuple[Body, ...]:
    """Shapes and bodies as bodies; one alone stands for a list of it.

    Raises TypeError for anything else, with its index.
    """
    if isinstance(items, (Shape, Body)):
        items = (items,)
    if isinstance(items, (str, bytes, Mapping)) or not isinstance(items, Iterable):
        raise TypeError(f"Scene: items must be a list of shapes and Bodies, or one of them, got {what(items)}")
    return tuple(_as_body(i, item) for i, item in enumerate(items))


def refuse_second(lights: Any) -> None:
    """TypeError for a second shape or body, which stands where lights do."""
    if isinstance(lights, (Shape, Body)):
        raise TypeError(f"Scene: items must be in one list, Scene([first, second]), got {what(lights)} as lights")


def _as_body(index: int, item: Any) -> Body:
    if isinstance(item, Body):
        return item
    if isinstance(item, Shape):
        return Body(item)
    hint = ""
    if isinstance(item, tuple) and len(item) > 1 and isinstance(item[0], Shape):
        hint = "; Body(shape, material, name) is one"
    elif hasattr(item, "bodies") or isinstance(item, list):
        hint = f"; {'a scene has these in .bodies: ' if hasattr(item, 'bodies') else ''}[*a, *b] is one list of two"
    raise TypeError(f"Scene: items[{index}] must be a shape or a Body, got {what(item)}{hint}")


def named(bodies: Sequence[Body], name: str) -> int:
    """The entry of a name; a KeyError that lists the names where there is none."""
    for entry, body in enumerate(bodies):
        if body.name == name:
            return entry
    known = [body.name for body in bodies if body.name]
    raise KeyError(f"no body named {shown(name)}; {known_names(name, 'named bodies', known)}")


def as_index(number: Any) -> int | None:
    """One integer, NumPy's too; None for anything else."""
    try:
        return None if isinstance(number, bool) else operator.index(number)
    except TypeError:
        return None


def numbered(firsts: Any, number: Any, called: str = "body: number") -> tuple[int, int]:
    """(entry, which of its bodies) of a body's number, which messages call so; firsts: see `first_numbers`."""
    index = as_index(number)
    if index is None:
        hint = "; hits.name and hits.material take all at once"
        if isinstance(number, str):
            hint = "; scene[name] is the entry of a name"
        raise TypeError(f"{called} must be one integer, got {shown(number)}{hint}")
    if not 0 <= index < firsts[-1]:
        miss = "; -1 stands for a miss" if index == -1 else ""
        raise IndexError(f"{called} must be at least 0 and below {firsts[-1]}, got {shown(index)}{miss}")
    entry = int(np.searchsorted(firsts, index, side="right")) - 1
    return entry, index - int(firsts[entry])


def exchanged(
    bodies: tuple[Body, ...], firsts: Any, which: Any, item: Any, labels: Mapping[str, Any]
) -> tuple[Body, ...]:
    """Bodies with one entry changed: the one of a name, or of a body's number. `labels`: a material, a name."""
    if not isinstance(item, (Shape, Body)) and not (item is None and labels):
        hint = "" if item is None or labels else "; material= and name= change these alone"
        raise TypeError(f"replace: item must be a shape or a Body, got {what(item)}{hint}")
    if not isinstance(which, str) and as_index(which) is None:
        raise TypeError(f"replace: which must be the name of an entry or the number of its body, got {shown(which)}")
    entry = named(bodies, which) if isinstance(which, str) else numbered(firsts, which, "replace: which number")[0]
    old = bodies[entry]
    if not isinstance(which, str) and isinstance(old.shape, Bulk):
        one = "ball" if isinstance(old.shape, Spheres) else "body"
        raise ValueError(
            f"replace: body {which} is one {one} of an entry of {len(old.shape):,}; name the entry instead"
        )
    new = old if item is None else item if isinstance(item, Body) else dataclasses.replace(old, shape=item)
    changes = {"name": new.name or old.name, **labels}
    return (*bodies[:entry], dataclasses.replace(new, **changes), *bodies[entry + 1 :])


def as_camera(camera: Any) -> Any:
    """A Camera, an OrthographicCamera, or None for one that fits; a TypeError otherwise."""
    if camera is None:
        return None
    from .render.camera import as_camera as checked

    return checked("Scene", camera)


def as_domain(domain: Any) -> Solid | None:
    """A solid, or None; a TypeError otherwise."""
    if domain is not None and not isinstance(domain, Solid):
        raise TypeError(f"Scene: domain must be a solid or None, got {what(domain)}")
    return domain
