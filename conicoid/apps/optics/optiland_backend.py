"""Optiland's non-sequential tracer with Conicoid's geometry: a backend, and components that are Boolean solids.

The classes that need Optiland are in `optiland_classes`, so that this module can be imported without it.
"""

from __future__ import annotations

import importlib
from typing import Any

from ...geometry.shape import Solid


def _classes() -> Any:
    """Return the module of classes that need Optiland."""
    try:
        return importlib.import_module(".optiland_classes", __package__)
    except ImportError as error:
        need = "needs Optiland 0.6 or newer: pip install 'conicoid[optiland]'"
        raise ImportError(f"co.optics.OptilandBackend {need} ({error})") from None


def OptilandBackend(seed: int | None = None) -> Any:
    """Make a `TracerBackend` for Optiland: ``scene.trace(rays, backend=co.optics.OptilandBackend(seed=1))``.

    Conicoid traces conics, planes within a circle or a rectangle, rings, cylindrical and conical edges, balls and
    solids of `optiland_component`, through its tree and without an epsilon: a ray knows the surface that it starts on.
    Optiland itself traces anything else (meshes), and the nearer hit counts. All light is Optiland's: sources,
    Fresnel's splitting, scatter, detectors, random numbers.

    Parameters
    ----------
    seed : int, optional
        Of the random numbers.

    Raises
    ------
    ImportError
        If Optiland is not installed.
    """
    return _classes().Backend(seed)


def optiland_component(solid: Solid, material: Any, outside: Any = None, *, cs: Any = None, name: str = "") -> Any:
    """Make a refracting component for Optiland's ``scene.add_component(name, component)`` from a Conicoid solid.

    The solid may be any Boolean combination: ``a & b`` and ``a - b``, which Optiland's `Volume.intersection` and
    `difference` refuse. Optiland's own backends trace it too, more slowly. In Optiland's records it is the ball around
    it.

    Parameters
    ----------
    solid : Solid
        In the frame of `cs`, of finite size.
    material : NSQMaterial or str
        An `NSQMaterial`, or the name of a glass of Optiland's.
    outside : NSQMaterial, optional
        The medium around it; the default is vacuum.
    cs : CoordinateSystem, optional
        Of Optiland's; the default is the world's.
    name : str
        Of the component.

    Raises
    ------
    ImportError
        If Optiland is not installed.
    """
    geometry = _classes().SolidGeometry(solid)
    # Imported after `_classes`, which explains a missing Optiland.
    from optiland.coordinate_system import CoordinateSystem
    from optiland.nonsequential.components.refractive import RefractiveComponent
    from optiland.nonsequential.materials.nsq_material import VACUUM, NSQMaterial

    glass = NSQMaterial.from_glass(material) if isinstance(material, str) else material
    medium = VACUUM if outside is None else outside
    return RefractiveComponent(cs or CoordinateSystem(), geometry, medium, glass, name=name)
