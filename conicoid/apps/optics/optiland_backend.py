"""Optiland's non-sequential tracer on Conicoid's geometry: a backend, and solids that may be Boolean.

What Optiland is needed for stands in `optiland_classes`, so that this much is there without it.
"""

from __future__ import annotations

import importlib
from typing import Any

from ..._util.hints import with_call_hints
from ...geometry.shape import Solid


def _classes() -> Any:
    """The module of classes that are Optiland's."""
    try:
        return importlib.import_module(".optiland_classes", __package__)
    except ImportError as error:
        told = "needs Optiland 0.6 or newer: pip install 'conicoid[optiland]'"
        raise ImportError(f"co.optics.OptilandBackend {told} ({error})") from None


@with_call_hints
def OptilandBackend(seed: int | None = None) -> Any:
    """A `TracerBackend` of Optiland's: ``scene.trace(rays, backend=co.optics.OptilandBackend(seed=1))``.

    Conics, planes within a circle or a rectangle, rings, cylindrical and conical edges, balls and solids of
    `optiland_component` are traced by Conicoid, through its tree and without an epsilon: a ray knows the surface that
    it starts on. Anything else (meshes) is traced by Optiland itself, and the nearer hit counts. What light does there
    is all Optiland's: sources, Fresnel's splitting, scatter, detectors, random numbers.

    seed: of the random numbers.
    Raises ImportError where Optiland is not installed.
    """
    return _classes().Backend(seed)


@with_call_hints
def optiland_component(solid: Solid, material: Any, outside: Any = None, *, cs: Any = None, name: str = "") -> Any:
    """A refracting component for Optiland's ``scene.add_component(name, component)`` that is a Conicoid solid.

    It may be any Boolean combination: ``a & b`` and ``a - b``, which Optiland's `Volume.intersection` and `difference`
    refuse. Optiland's own backends trace it, too, and more slowly. To Optiland's records it is the ball around it.

    solid: in the frame of `cs`, of finite size. material: an `NSQMaterial`, or the name of a glass of Optiland's.
    outside: the `NSQMaterial` around it, vacuum where left out. cs: a `CoordinateSystem` of Optiland's, the world's
    where left out. name: of the component.
    Raises ImportError where Optiland is not installed.
    """
    geometry = _classes().SolidGeometry(solid)
    from optiland.coordinate_system import CoordinateSystem
    from optiland.nonsequential.components.refractive import RefractiveComponent
    from optiland.nonsequential.materials.nsq_material import VACUUM, NSQMaterial

    glass = NSQMaterial.from_glass(material) if isinstance(material, str) else material
    around = VACUUM if outside is None else outside
    return RefractiveComponent(cs or CoordinateSystem(), geometry, around, glass, name=name)
