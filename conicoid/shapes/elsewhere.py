"""What is asked of a shape or a body, and has its place elsewhere."""

from __future__ import annotations

OF_SCENES = (
    "render", "section", "view", "first_hit", "occluded", "spans", "crossings", "lengths", "line_integral", "contains",
    "body_at", "save", "prepare", "fitting_camera",
)  # fmt: skip
"""What a scene of the shape can be asked."""
OF_MEASURES = ("volume", "area", "centroid", "inertia")


def no_attribute(thing: object, name: str) -> AttributeError:
    """The error for an attribute that there is not, which says where it is."""
    kind, hint = type(thing).__name__, ""
    if name in OF_SCENES:
        hint = f": a scene has, co.Scene({kind.lower()}).{name}(...)"
    elif name in OF_MEASURES:
        hint = f": co.measure({kind.lower()}).{name} is that"
    return AttributeError(f"{kind!r} object has no attribute {name[:80]!r}{hint}", name=name, obj=thing)
