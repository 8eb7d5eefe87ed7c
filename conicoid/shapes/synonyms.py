"""What arguments are called in other programs: for messages of calls that do not fit, and of keys in scene files."""

from __future__ import annotations

from collections.abc import Collection

_MEANT = {
    "fov": "field_of_view|camera (its field_of_view)|height (of the window)",
    "fovy": "field_of_view|camera (its field_of_view)",
    "fovx": "field_of_view (the vertical one)", "n": "refractive_index", "num": "rays", "ior": "refractive_index",
    "index": "refractive_index", "r": "radius", "angle": "degrees|field_of_view|start_radius and end_radius",
    "deg": "degrees", "radians": "degrees", "size": "width and height|scale", "resolution": "width and height",
    "shape": "width and height|item", "aspect": "width and height", "spp": "samples", "samples": "rays",
    "n_rays": "rays",
    "num_rays": "rays", "nrays": "rays", "eye": "position", "from": "position", "look_from": "position",
    "lookfrom": "position", "target": "look_at|direction (target - position)|directions (target - origins)",
    "lookat": "look_at|direction (look_at - position)", "to": "look_at|direction",
    "center": "look_at|about|start and end", "position": "center|camera (its position)|origins",
    "up": "camera (its up)",
    "centre": "center|look_at|start and end", "pos": "position|center", "location": "position|center",
    "pivot": "about", "origin": "center|position|about", "point": "about|points|center|offset (normal·point)",
    "vup": "up",
    "up_vector": "up", "height": "start and end", "length": "start and end", "p1": "start", "p2": "end",
    "base": "start", "top": "end", "radius1": "start_radius", "radius2": "end_radius", "r1": "start_radius",
    "r2": "end_radius", "diameter": "radius (half of it)", "min": "low", "max": "high",
    "axis": "plane|direction|start and end", "value": "at|values", "apex": "start and end",
    "radius": "start_radius and end_radius",
    "vector": "offset|direction|axis", "distance": "t_max|offset", "d": "offset|directions", "o": "origins",
    "objects": "items|bodies",
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
    **dict.fromkeys(("semi_axes", "semiaxes", "axes", "a", "b", "c"), "radii"),
    **dict.fromkeys(("xmin", "xmax", "ymin", "ymax", "zmin", "zmax", "x_min", "x_max"), "low and high"),
    **dict.fromkeys(("x0", "y0", "z0"), "center|normal and offset"),
    **dict.fromkeys(("x", "y", "z"), "normal and offset|offset (a vector, (x, y, z))"),
    **dict.fromkeys(("max_t", "maxt", "far", "tfar", "max_distance", "max_dist", "max_range", "range"), "t_max"),
    **dict.fromkeys(("min_t", "mint", "near", "tnear", "min_distance"), "t_min"),
    **dict.fromkeys(("default", "fill_value", "missing"), "otherwise"),
    **dict.fromkeys(("positions", "coords", "xyz"), "centers"),
    **dict.fromkeys(("vertices", "faces"), "normals and offsets"),
    **dict.fromkeys(("material_id", "id", "nuclides", "attenuation"), "properties"),
    **dict.fromkeys(("det_spacing", "pixel_size", "detector_width", "det_width", "pixel_spacing"), "spacing"),
    **dict.fromkeys(("sod", "source_distance", "dso", "sid"), "source_origin|source_to_isocenter"),
    **dict.fromkeys(("odd", "detector_distance", "ddo"), "origin_detector"),
    **dict.fromkeys(("sdd", "dsd"), "origin_detector (sdd - source_origin)|source_to_detector"),
    **dict.fromkeys(("theta", "views", "projections"), "degrees|angles"), "det_count": "columns", "ncols": "columns",
    "detectors": "columns", "det_row_count": "rows", "nrows": "rows", "zoom": "height (of the window)",
    "scale": "height (of the window)", "rays": "origins",
    "n2": "eta (index before / index behind)", "look_at": "direction (look_at - position)|camera (its look_at)",
    "direction": "directions|look_at (position + direction)", "fps": "frames and seconds", "duration": "seconds",
    "field_of_view": "camera (its field_of_view)|height (of the window)", "width": "height (of the window)",
}  # fmt: skip
"""What each is here: the first of these that a call takes, with what there is to say of it in brackets."""


def meant_by(name: str, known: Collection[str]) -> str:
    """The argument, or arguments, of some that a name stands for elsewhere; empty where there is none."""
    for meant in _MEANT.get(name.casefold(), "").split("|"):
        if meant.endswith("(of the window)") and "look_at" not in known:  # a picture has a height as well
            continue
        if meant and set(meant.partition(" (")[0].split(" and ")) <= set(known):
            return meant
    return ""
