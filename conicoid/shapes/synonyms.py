"""What arguments are called in other programs: for messages of calls that do not fit, and of keys in scene files."""

from __future__ import annotations

from collections.abc import Collection

_MEANT = {
    "fov": "field_of_view|height (of the window)", "fovy": "field_of_view",
    "fovx": "field_of_view (the vertical one)", "n": "refractive_index", "num": "rays", "ior": "refractive_index",
    "index": "refractive_index", "r": "radius", "angle": "degrees|field_of_view", "theta": "degrees",
    "deg": "degrees", "radians": "degrees", "size": "width and height|scale", "resolution": "width and height",
    "shape": "width and height", "aspect": "width and height", "spp": "samples", "samples": "rays", "n_rays": "rays",
    "num_rays": "rays", "nrays": "rays", "eye": "position", "from": "position", "look_from": "position",
    "lookfrom": "position", "target": "look_at|direction (target - position)",
    "lookat": "look_at|direction (look_at - position)", "to": "look_at|direction", "center": "look_at|about",
    "centre": "center|look_at", "position": "center", "pos": "position|center", "location": "position|center",
    "pivot": "about", "origin": "center|position|about", "point": "about|points|center", "vup": "up",
    "up_vector": "up", "height": "start and end", "length": "start and end", "p1": "start", "p2": "end",
    "base": "start", "top": "end", "radius1": "start_radius", "radius2": "end_radius", "r1": "start_radius",
    "r2": "end_radius", "diameter": "radius (half of it)", "min": "low", "max": "high", "axis": "direction",
    "vector": "offset|direction|axis", "distance": "t_max|offset", "d": "offset", "objects": "items|bodies",
    "geometry": "bodies", "version": "conicoid", "shapes": "items", "bodies": "items", "light": "lights",
    "bg": "background", "sky": "background", "file": "path", "filename": "path",
    "color": "color|intensity|material|transparency (a colour tints at each wall)",
    "colour": "color|intensity|material|transparency (a colour tints at each wall)", "rgb": "color|intensity",
    "power": "intensity", "strength": "intensity", "brightness": "intensity", "energy": "intensity",
    "alpha": "transparency", "opacity": "transparency", "transmission": "transparency", "roughness": "shininess",
    "mu": "properties", "density": "properties", "reflection": "reflectivity", "cmap": "colormap",
    "palette": "colormap", "clim": "vmin and vmax", "data": "array", "image": "array", "tmin": "t_min",
    "tmax": "t_max", "callback": "progress", "verbose": "progress", "random_state": "seed", "rng": "seed",
    "max_depth": "depth", "bounces": "depth", "n1": "eta (index before / index behind)",
    "n2": "eta (index before / index behind)", "look_at": "direction (look_at - position)",
    "direction": "directions|look_at (position + direction)", "fps": "frames and seconds", "duration": "seconds",
    "field_of_view": "height (of the window)", "width": "height (of the window)",
}  # fmt: skip
"""What each is here: the first of these that a call takes, with what there is to say of it in brackets."""


def meant_by(name: str, known: Collection[str]) -> str:
    """The argument, or arguments, of some that a name stands for elsewhere; empty where there is none."""
    for meant in _MEANT.get(name.casefold(), "").split("|"):
        if meant and set(meant.partition(" (")[0].split(" and ")) <= set(known):
            return meant
    return ""
