"""What is asked of answers, rays, materials, measures, pictures and cameras by names that other systems have."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from .hints import closest_name

Kind = TypeVar("Kind", bound=type)
_ATTRIBUTE_CUTOFF = 0.75
_NAME_LENGTH = 80


def _hint_names(hint: str, names: str) -> dict[str, str]:
    return dict.fromkeys(names.split(), hint)


_ARRAY_METHOD_HINTS = _hint_names(
    "its fields are arrays and have that: {0}.{1}.{2}()", "min max mean sum std argmin argmax"
)
_RESHAPE_HINTS = _hint_names(
    "it has the shape of its rays: ask with rays of another, or reshape a field, {0}.{1}.reshape(...)",
    "reshape ravel flatten squeeze T transpose",
)
_TABLE_HINTS = _hint_names(
    "{0}.save(path) writes a .npz file; the fields are arrays for any table, such as {0}.{1}",
    "to_csv to_dataframe to_pandas to_dict to_numpy tolist to_list save_csv",
)
_BODY_FIELD_HINTS = {
    **_hint_names(
        "it is called body, the number of each; {0}.name and {0}.material are what scene.body(number) has",
        "bodies body_id body_ids ids id obj object objects index indices primitive geom_id geomID",
    ),
    **_hint_names("it is called name", "names label labels"),
    **_hint_names("materials have that: {0}.material, and .color of each", "color colors colour"),
    **_hint_names("materials keep that: {0}.material, and .properties of each", "properties density"),
}


def _ray_field_hints(name: str) -> dict[str, str]:
    plain = f"rays.{name}s"
    return {f"{name}s": f"{{0}}.{plain} is that", name: f"{{0}}.{plain} is that"}


_ATTRIBUTE_HINTS: dict[str, dict[str, str]] = {
    "Hits": {
        **_hint_names("hits[mask] selects, as hits[hits.hit]", "filter where select first nonzero head"),
        **_hint_names("it is called name, and scene.body(number) is the body of one", "body_name body_names"),
        **_hint_names(
            "it is called face, the number within the body", "primID primitive_ids prim_ids triangle_id index_tri"
        ),
        **_hint_names("it is called body, the number of each", "geometry_ids geometry_id geomid instID instance"),
        **_hint_names(
            "it is called rays, hits.rays[i] is one",
            "ray_index index_ray ray_ids dir incident wo wi ray ray_directions",
        ),
        **_hint_names(
            "-(hits.rays.directions * hits.normal).sum(-1) is the cosine, where directions are unit",
            "cos cosine angle angles incidence angle_of_incidence cos_theta theta incidence_angle",
        ),
        **_hint_names("triangles have (β, γ) in uv", "barycentric barycentrics primitive_uvs"),
        **_hint_names(
            "a scene is asked again: scene.first_hit(hits.spawn(directions))", "to_world offset continue_ spawn_ray"
        ),
        **_hint_names("the scene is where it was asked, hits keep its names and materials", "scene"),
        **_hint_names(
            "the fields are t, point, normal, body, face, surface, uv and more", "keys fields columns items values"
        ),
        **_hint_names("hits.hit.sum() is how many rays hit, len(hits) how many there are", "count n_hits num_hits"),
        **_hint_names("scene.contains(points) tells that", "is_inside contains"),
        **_hint_names("hits[np.argsort(hits.t)] are in the order of t", "sort sorted argsort sort_values"),
        **_ARRAY_METHOD_HINTS,
        **_RESHAPE_HINTS,
        **_TABLE_HINTS,
        **_BODY_FIELD_HINTS,
        **_ray_field_hints("origin"),
        **_ray_field_hints("direction"),
        **_hint_names(
            "it is called point", "points position positions location locations hit_point intersection p xyz coords"
        ),
        **_hint_names(
            "hits.t is that, in units of the length of the direction", "distance distances depth dist tfar tnear tmin"
        ),
        **_hint_names("it is called normal", "normals n N normal_vector Ng"),
        **_hint_names("it is called face", "faces face_id prim_id"),
        **_hint_names(
            "it is called hit, true where there was one, and ~hits.hit",
            "mask valid is_hit hits found did_hit miss missed any all",
        ),
        **_hint_names("~hits.entering is that, where hits.hit is true", "inside is_inside exiting leaving front_face"),
        **_hint_names("it is called t_error, and point_error for the place", "error errors uncertainty"),
        **_hint_names("it is called surface", "surfaces"),
        **_hint_names("it is called material", "materials"),
        **_hint_names("it is called uv, hits.uv[..., 0] is u", "u v texcoord"),
        **_hint_names(
            "co.{2}(hits.rays.directions, hits.normal, ...) has directions, and hits.spawn(directions) the rays",
            "reflect refract",
        ),
        **_hint_names(
            "hits.spawn(co.reflect(hits.rays.directions, hits.normal)) are the mirrored rays",
            "bounce reflected reflected_rays",
        ),
        **_hint_names("scene.spans(rays) has that", "t_enter t_exit offsets lengths length thickness spans"),
        **_hint_names("scene.crossings(rays) has all of them, not the first alone", "all_hits second next crossings"),
        **_hint_names("hits.detached() stays without the scene; hits are read-only and need no copies", "copy"),
    },
    "Rays": {
        **_hint_names("a scene is asked: scene.first_hit(rays).{2}", "t body normal hit_point uv face material"),
        **_hint_names(
            "rays.origins + t[..., None] * rays.directions are points at t; of hits, hits.point",
            "at point_at points point evaluate position end",
        ),
        **_RESHAPE_HINTS
        | _hint_names(
            "co.Rays(rays.origins.reshape(..., 3), rays.directions.reshape(..., 3)) are plain rays of another "
            "shape; rays[...] selects, rays[:, None] has one axis more",
            "reshape ravel flatten squeeze transpose T",
        ),
        **_hint_names("it is called origins", "origin o org orig start starts position source"),
        **_hint_names("it is called directions", "direction d dir dirs"),
        **_hint_names("directions may have any length, and t is in units of it", "normalize normalized unit normalise"),
        **_hint_names(
            "intervals go with the question: scene.first_hit(rays, t_min=0, t_max=9)",
            "t_min t_max tmin tmax tnear tfar mint maxt interval",
        ),
        **_hint_names(
            "rays are arrays: co.Rays(rays.origins + offset, rays.directions)",
            "translate move rotate transform scale offset",
        ),
        **_hint_names("co.Rays.concatenate([a, b]) joins rays", "append extend join concat stack"),
        **_hint_names("a scene is asked, scene.{2}(rays)", "first_hit occluded spans crossings lengths line_integral"),
        **_hint_names("a scene is asked, scene.first_hit(rays)", "trace cast intersect hit hits"),
        **_hint_names(
            "spawned rays know the surface that they start on by themselves", "surface surfaces start_surface"
        ),
        **_hint_names("rays are read-only and need no copies", "copy"),
        **_TABLE_HINTS,
    },
    "Spans": {
        **_ARRAY_METHOD_HINTS,
        **_RESHAPE_HINTS,
        **_TABLE_HINTS,
        **_BODY_FIELD_HINTS,
        **_ray_field_hints("origin"),
        **_ray_field_hints("direction"),
        **_hint_names(
            "spans.lengths() are true lengths, by ray and body",
            "length distance distances thickness path_length path_lengths chord chords chord_length total sum",
        ),
        **_hint_names("it is called t_enter", "t0 start starts begin enter entry t_start t_in t_min tmin near"),
        **_hint_names("it is called t_exit", "t1 end ends exit leave t_end t_out t_max tmax far"),
        **_hint_names("the two ends of each are t_enter and t_exit", "t ts intervals segments"),
        **_hint_names(
            "scene.crossings(rays) has point and normal of every end",
            "point points normal normals face faces surface entering",
        ),
        **_hint_names("spans.lengths(by='material') is that", "by_material material_lengths lengths_by_material"),
        **_hint_names(
            "spans.line_integral(values) is the sum of value times length", "integral integrate weighted_sum"
        ),
        **_hint_names("np.diff(spans.offsets) has how many each ray has", "count counts n number size"),
        **_hint_names("np.diff(spans.offsets) > 0 has which rays have any", "hit hits any mask"),
    },
    "Crossings": {
        **_ARRAY_METHOD_HINTS,
        **_RESHAPE_HINTS,
        **_TABLE_HINTS,
        **_BODY_FIELD_HINTS,
        **_ray_field_hints("origin"),
        **_ray_field_hints("direction"),
        **_hint_names("crossings.t is that, in units of the length of the direction", "distance distances depth dist"),
        **_hint_names("it is called point", "points position positions location"),
        **_hint_names("it is called normal", "normals n"),
        **_hint_names("scene.spans(rays) has that", "t_enter t_exit lengths length line_integral thickness"),
        **_hint_names("scene.first_hit(rays) has that, of the first one", "uv local_point point_error"),
        **_hint_names("it is called entering", "enter exit exiting leaving inside"),
        **_hint_names(
            "crossings.point are the places, and scene.first_hit(rays) has the first of each ray", "hits first"
        ),
        **_hint_names("np.diff(crossings.offsets) has how many each ray has", "count counts number size hit"),
    },
    "Material": {
        **_hint_names(
            "it is called color, linear rgb or a text", "colour rgb diffuse_color albedo base_color kd Kd reflectance"
        ),
        **_hint_names("it is called refractive_index", "ior n index eta refraction index_of_refraction"),
        **_hint_names("it is called transparency", "alpha opacity transmission transmittance"),
        **_hint_names("it is called shininess, the greater the smoother", "glossiness gloss exponent"),
        **_hint_names("it is called specular", "specular_color ks Ks"),
        **_hint_names("it is called reflectivity", "mirror reflection metallic"),
        **_hint_names("it is called emission, the radiance of a surface", "emissive emitted glow light"),
        **_hint_names(
            "dataclasses.replace(material, field=...) is another; materials do not change",
            "replace copy set update with_",
        ),
        **_hint_names(
            "material.properties is a mapping of your own values, given as properties={{...}}",
            "density mu attenuation mass id data userdata user_data metadata Z sigma temperature set_density "
            "add_nuclide add_element add_nuclides",
        ),
    },
    "Measures": {
        **_hint_names(
            "volume times a density is that: measures.volume * material.properties['density']", "mass weight"
        ),
        **_hint_names("it is called centroid", "center centre center_of_mass com cog mean barycenter"),
        **_hint_names("it is called area", "surface_area surface"),
        **_hint_names(
            "it is called inertia, for density 1",
            "moment moments moment_of_inertia inertia_tensor moments_of_inertia I tensor",
        ),
        **_hint_names(
            "each value has its own: volume_error, area_error, centroid_error, inertia_error",
            "error errors std sigma uncertainty",
        ),
        **_hint_names("the shape has that, shape.bounds", "bounds bbox extent"),
        **_hint_names("co.measure(scene).names are those of bodies, in the order of their measures", "name names body"),
        **_hint_names("materials keep that, material.properties", "density"),
    },
    "SceneMeasures": {
        **_hint_names(
            "each material and body has that: found.by_material[0].{2}, found['name'].{2}, found[0].{2}",
            "area area_error centroid centroid_error inertia inertia_error rays",
        ),
        **_hint_names(
            "it is called volume, an array by body; found['name'].volume is that of a material or body", "volumes total"
        ),
        **_hint_names(
            "the volume of each times its density is that: found.by_material goes with found.materials",
            "mass masses weight",
        ),
        **_hint_names(
            "found['name'] has those of a material or body, found.by_material of all materials", "items keys values get"
        ),
    },
    "Image": {
        **_hint_names(
            "image.pixels.shape is (height, width, 3); image.width and image.height are its sides",
            "shape size resolution dtype",
        ),
        **_hint_names(
            "image.pixels is linear light, and np.asarray(image) the bytes that are shown",
            "array data numpy rgb to_numpy tolist astype",
        ),
        **_hint_names("image.show() shows it, and image.save(path) writes it", "plot imshow display view write export"),
        **_hint_names(
            "PIL.Image.fromarray(np.asarray(image)) is a picture of Pillow, whose save also takes a file in memory",
            "to_bytes tobytes bytes to_pil pil __array_interface__",
        ),
        **_hint_names(
            "scenes are rendered in any size, and PIL.Image.fromarray(np.asarray(image)) is a picture to edit",
            "resize crop rotate convert thumbnail",
        ),
        **_ARRAY_METHOD_HINTS,
    },
    "Camera": {
        **_hint_names("it is called field_of_view, in degrees", "fov fovy fov_y angle"),
        **_hint_names("it is called position", "eye location origin center pos"),
        **_hint_names("it is called look_at", "target lookat at focus"),
        **_hint_names(
            "a Camera has aperture, the diameter of its lens, and focus_distance", "f_stop fstop f_number focal_length"
        ),
        **_hint_names("a scene has it, scene.render(width, height, camera=camera)", "render picture shoot"),
        **_hint_names(
            "dataclasses.replace(camera, position=...) is another camera; cameras do not change",
            "move translate rotate orbit zoom copy replace moved translated rotated pan dolly",
        ),
        **_hint_names("it is worked out: look_at - position, at any length", "direction forward"),
        **_hint_names(
            "it is that of a picture: width / height of scene.render(width, height)", "aspect aspect_ratio width"
        ),
        **_hint_names("it is called rays(width, height)", "get_rays generate_rays ray"),
    },
}
_ATTRIBUTE_HINTS["SceneMeasures"] |= _hint_names(
    "found.volume.sum() is that of all bodies", "sum mean total_volume"
) | _hint_names(
    "found.names, found.volume and found.bodies are columns of a table, and `conicoid measure` writes one as .csv",
    "to_csv to_dataframe to_pandas to_dict to_numpy tolist to_list save_csv save",
)
_ATTRIBUTE_HINTS["Classification"] = {
    **_hint_names("they are called semi_axes", "radius radii half_axes semiaxes a b c"),
    **_hint_names("it is called kind", "type name family"),
    **_hint_names("it is called center", "centre vertex apex origin point"),
    **_hint_names("they are called axes, and a body of revolution has its own last", "axis direction directions"),
    **_hint_names("it is called revolution", "is_revolution symmetric"),
}
_ATTRIBUTE_HINTS["Finding"] = {
    **_hint_names("a ray that shows it is finding.origin and finding.direction", "ray rays origins directions"),
    **_hint_names("it is called message, and str(finding) is all of it", "text description msg reason info"),
    **_hint_names("it is called size", "volume thickness length overlap extent"),
    **_hint_names("it is called kind", "type category severity level"),
    **_hint_names("it is called bodies, their numbers", "body names name ids"),
    **_hint_names("it is called size_error", "error volume_error"),
    **_hint_names(
        "it is called point, for undefined regions; others have a ray, origin and direction", "position location"
    ),
}
_ATTRIBUTE_HINTS["Molecule"] = {
    **_hint_names(
        "they are called symbols, and numbers the atomic numbers", "elements element symbol species atoms types"
    ),
    **_hint_names("it is called positions", "coordinates coords xyz points position"),
}
_ATTRIBUTE_HINTS["Paths"] = _hint_names(
    "paths.wall and paths.body are numbers of bodies: scene.body(number).name is that of one", "name names material"
)
_ATTRIBUTE_HINTS["CameraRays"] = {
    **_hint_names("rays.made().{2} is that: these rays are made where they are traced", "origins directions"),
    **_hint_names(
        "rays.made() are rays in arrays, which have that", "save concatenate copy origin direction reshape spawn"
    ),
    **_hint_names("a scene is asked, scene.{2}(rays)", "first_hit occluded spans crossings lengths line_integral"),
}
_ATTRIBUTE_HINTS["ScanRays"] = _ATTRIBUTE_HINTS["CameraRays"]
_ATTRIBUTE_HINTS["ScanGeometry"] = {
    **_hint_names("co.Rays.from_scan(geometry) are its rays", "rays get_rays directions origins ray pixels_rays"),
    **_hint_names(
        "it is kept in vectors, twelve numbers a view, not as angles",
        "angles theta source_origin origin_detector pitch",
    ),
    **_hint_names(
        "u and v in vectors, geometry.vectors[:, 6:9] and [:, 9:], are the steps of pixels", "spacing pixel_size offset"
    ),
    **_hint_names("it is called views", "n_views num_views count projections"),
    **_hint_names("co.ct.project(scene, geometry, values) is the sinogram", "project sinogram trace"),
    **_hint_names(
        "geometry.pixels(view, row, column) are centres to plot, vectors[:, :3] the sources", "plot show sources"
    ),
}
_ATTRIBUTE_HINTS["OrthographicCamera"] = _ATTRIBUTE_HINTS["Camera"] | _hint_names(
    "parallel rays have no angle; height is that of the window", "fov fovy field_of_view angle"
)
_ATTRIBUTE_HINTS["EquirectangularCamera"] = _ATTRIBUTE_HINTS["Camera"] | _hint_names(
    "it sees all around, 360 by 180 degrees", "fov fovy field_of_view angle"
)
_ATTRIBUTE_HINTS["FisheyeCamera"] = _ATTRIBUTE_HINTS["Camera"]
_FIRST_FIELDS = {"Hits": "t", "Spans": "t_enter", "Crossings": "t", "Rays": "origins", "Image": "pixels"}


def with_attribute_hints(kind: Kind) -> Kind:
    """A class that tells of names that it does not have what they are here."""
    setattr(kind, "__getattr__", _raise_attribute_error)  # noqa: B010 (checkers would let any attribute be asked for)
    return kind


def _raise_attribute_error(thing: object, name: str) -> Any:
    """The error for an attribute that there is not."""
    kind = type(thing).__name__
    hint = (
        ""
        if name.startswith("_") and name not in _ATTRIBUTE_HINTS.get(kind, ())
        else _attribute_hint(thing, kind, name)
    )
    text = f"{kind!r} object has no attribute {name[:_NAME_LENGTH]!r}{': ' if hint else ''}{hint}"
    raise AttributeError(text, name=name, obj=thing)


def _attribute_hint(thing: object, kind: str, name: str) -> str:
    own = getattr(thing, "properties", None) if kind == "Material" else None
    if own is not None and name in own:
        return f"material.properties[{name!r}] is that"
    if name in _ATTRIBUTE_HINTS.get(kind, ()):
        return _ATTRIBUTE_HINTS[kind][name].format(kind.lower(), _FIRST_FIELDS.get(kind, ""), name)
    fields = [field for field in {*dir(type(thing)), *getattr(thing, "__dict__", ())} if not field.startswith("_")]
    close = closest_name(name, sorted(fields), _ATTRIBUTE_CUTOFF)
    return f"did you mean {close}?" if close else ""


# What scenes of other packages are asked, and what answers it here.


def _scene_hint_names(hint: str, names: str) -> dict[str, str]:
    return dict.fromkeys(names.split(), hint)


_IMMUTABLE_SCENE = "scenes do not change: scene.{0} is another scene"
SCENE_HINTS = {
    **_scene_hint_names(
        "it is called first_hit(origins, directions), t of a miss being inf",
        "first_hits closest_hit closest_hits nearest nearest_hit closest ray_intersect ray_intersection cast_rays "
        "cast_ray intersects_first intersects_location intersects_id "
        "ray_trace raytrace trace_rays shoot_rays "
        "hits find_hit intersect_rays intersect_ray intersections multi_ray_trace ray_cast",
    ),
    **_scene_hint_names(
        "it is called occluded(origins, directions, t_max=1), where directions are target - origin",
        "visible is_visible visibility line_of_sight shadow in_shadow ray_test test_occlusions intersects_any any_hit "
        "is_occluded occlusion blocked",
    ),
    **_scene_hint_names(
        "it is called explain(origin, direction)", "why debug_ray trace_one work_out show_ray inspect_ray"
    ),
    **_scene_hint_names(
        "it is called crossings(rays), all of each ray", "all_hits every_hit all_intersections intersects_all"
    ),
    **_scene_hint_names(
        "np.diff(scene.crossings(rays).offsets) has how many each ray has", "count_intersections count_hits"
    ),
    **_scene_hint_names(
        "it is called lengths(rays), by body, or with by='material'",
        "path_lengths path_length ray_length ray_lengths chords chord_lengths thickness track_lengths distances",
    ),
    **_scene_hint_names(
        "it is called line_integral(values, rays)",
        "project projection optical_depth attenuation integrate radiograph sinogram transmission",
    ),
    **_scene_hint_names(
        "scene.body_at(points) has the numbers of bodies, and scene.body(number).material what one is made of",
        "material_at find find_cell cell_at which_body locate name_at inside_body point_in",
    ),
    **_scene_hint_names(
        "scene.bodies, scene.bounds, scene.materials and scene.memory are that; `conicoid info scene.yaml` prints them",
        "info describe summary statistics stats print report",
    ),
    **_scene_hint_names("scenes are asked by rays, scene.first_hit(origins, directions)", "query ask evaluate run"),
    **_scene_hint_names(
        "it is called contains(points)", "contains_points compute_occupancy is_inside inside point_inside"
    ),
    **_scene_hint_names(
        "scene.distance(points) is the distance from the nearest wall, with exact=True the nearest point",
        "signed_distance compute_distance compute_signed_distance closest_point closest_points "
        "compute_closest_points sdf",
    ),
    **_scene_hint_names("it is called bounds", "aabb aabbs bbox bounding_box box get_bounds get_aabb bbox_min limits"),
    **_scene_hint_names(
        "scene.bodies are the entries, and scene[name] one of them; scene.bodies.index(name) is its place",
        "number body_number "
        "get keys values body_index index body_names cells get_all_cells get_all_bodies children root_universe "
        "universe surfaces get_all_surfaces geometries meshes nodes entries find_body",
    ),
    **_scene_hint_names("it is called materials", "get_all_materials material_names mats"),
    **_scene_hint_names("it is called lights", "emitters light sources"),
    **_scene_hint_names("it is called camera, None for a scene without", "sensors sensor cameras view_point"),
    **_scene_hint_names("it is called background", "environment env sky world"),
    **_scene_hint_names(
        "it is called save(path)", "write to_yaml to_json to_file dump dumps export_yaml save_yaml to_string to_dict"
    ),
    **_scene_hint_names(
        "pictures are asked for: scene.render(width, height)", "render_image render_scene picture image draw capture"
    ),
    **_scene_hint_names(
        "scene.render().show() shows a picture, scene.view() the scene", "show plot display imshow preview"
    ),
    **_scene_hint_names(
        "nothing is turned into triangles: surfaces are exact", "to_mesh mesh triangulate to_trimesh to_stl to_obj"
    ),
    **_scene_hint_names(
        _IMMUTABLE_SCENE.format("added(items)"),
        "add_object add_objects add_sphere add_box add_triangles add_geometry add_mesh",
    ),
    **_scene_hint_names(_IMMUTABLE_SCENE.format("replace(lights=[...])"), "add_light add_lights set_lights"),
    **_scene_hint_names(_IMMUTABLE_SCENE.format("without(which)"), "delete pop clear drop discard"),
    **_scene_hint_names(
        "co.check(scene) finds overlaps, each with a ray", "overlaps find_overlaps overlapping is_watertight is_valid"
    ),
    **_scene_hint_names("it is called section(plane, at), or slice(plane, at=...)", "cut cross_section clip"),
    **_scene_hint_names("it is called voxels(bounds, shape)", "voxelize voxelise rasterize to_grid volume_fractions"),
    **_scene_hint_names(
        "scenes are put together by their entries, co.Scene([*a.bodies, *b.bodies], a.lights)",
        "union merge join combine concatenate",
    ),
}
"""Names of Raysect, Mitsuba, Open3D, trimesh, PyVista and OpenMC, and of no package at all, and what there is here."""
CLASS_METHOD_HINTS = {
    "Scene": _scene_hint_names(
        "co.load(path) reads a scene file", "from_yaml from_file read open from_json parse loads from_string"
    )
    | _scene_hint_names("co.load_openmc(path) reads OpenMC's geometries", "from_openmc from_xml load_openmc")
    | _scene_hint_names(
        "what a scene is made of is handed to it, co.Scene([bodies], lights, camera)", "from_dict from_list create"
    ),
    "Image": _scene_hint_names(
        "images are made of arrays, co.Image(np.asarray(PIL.Image.open(path)))", "load open read from_file imread"
    )
    | _scene_hint_names("images are made of arrays, co.Image(array)", "fromarray from_array frombytes"),
    "Rays": _scene_hint_names(
        "directions are differences, co.Rays(origins, targets - origins)", "from_points between look_at to towards"
    )
    | _scene_hint_names("it is called concatenate([a, b])", "stack concat join merge append hstack vstack")
    | _scene_hint_names("it is called load(path)", "from_file from_npz from_csv from_npy read open"),
    "Hits": _scene_hint_names("it is called load(path)", "from_file from_npz read open")
    | _scene_hint_names("it is called concatenate([a, b])", "stack concat join merge"),
}
"""What classes of other packages are asked, such as `Scene.from_yaml`."""


# What is asked of a shape, a body or a scene, and has another name or its place elsewhere.

SCENE_METHODS = (
    "render", "section", "view", "first_hit", "occluded", "spans", "crossings", "lengths", "line_integral", "contains",
    "body_at", "bodies_at", "slice", "voxels", "stream", "save", "prepare", "fitting_camera", "explain", "distance",
)  # fmt: skip
"""What a scene of the shape can be asked."""
MEASURE_FIELDS = ("volume", "area", "centroid", "inertia")
PACKAGE_FUNCTIONS = ("check", "measure", "export", "turntable", "animate")
"""Functions of the package, not methods."""
SHAPE_SYNONYMS = {
    "move": "translate", "moved": "translate", "translated": "translate", "rotated": "rotate", "scaled": "scale",
    "apply_transform": "transform", "bbox": "bounds", "aabb": "bounds", "bounding_box": "bounds", "extent": "bounds",
    "extents": "bounds",
}  # fmt: skip
"""Names that other systems have, and the ones here."""
_OPERATOR_SYNONYMS = {
    "union": "|", "unite": "|", "add": "|", "intersection": "&", "intersect": "&", "difference": "-", "subtract": "-",
    "cut": "-", "minus": "-",
}  # fmt: skip
_BODY_FIELDS = ("material", "color", "name")
_OPERAND_FIELDS = (
    "radius",
    "radii",
    "low",
    "high",
    "start",
    "end",
    "normal",
    "offset",
    "left",
    "right",
    "a",
    "b",
    "children",
)
"""What primitives have, or two operands elsewhere, that a Boolean does not."""
CLASS_SYNONYMS = {
    "Ball": "Sphere", "Cuboid": "Box", "Cube": "Box", "Block": "Box", "Pipe": "Tube", "Tubs": "Tube", "Cons": "Cone",
    "Ray": "Rays", "Hit": "Hits", "Span": "Spans", "Circle": "Disc", "Disk": "Disc", "Group": "Union",
    "Frustum": "Cone", "Light": "PointLight",
    "Tetrahedron": "Polyhedron", "Paraboloid": "EllipticParaboloid", "Hyperboloid": "OneSheetHyperboloid",
    "PerspectiveCamera": "Camera", "Pinhole": "Camera", "PinholeCamera": "Camera", "Texture": "Checker",
    "Checkerboard": "Checker", "EnvironmentMap": "Environment", "Sun": "DirectionalLight",
    "SunLight": "DirectionalLight", "AreaLight": "glow", "Not": "Complement", "And": "Intersection", "Or": "Union",
    "Minus": "Difference", "Plastic": "plastic", "diffuse": "matte", "lambertian": "matte", "Lambertian": "matte",
    "dielectric": "glass", "Dielectric": "glass", "metallic": "metal", "emissive": "glow", "write": "save",
    "dump": "save", "read": "load", "open": "load", "import_openmc": "load_openmc", "from_openmc": "load_openmc",
    "volume": "measure", "validate": "check", "gif": "turntable", "snell": "refract",
    "to_html": "export", "Rectangle": "Polygon", "Square": "Polygon", "Quad": "Polygon",
    "Subtract": "Difference", "Subtraction": "Difference", "Intersect": "Intersection", "Unite": "Union",
    "unite": "Union", "HollowCylinder": "Tube", "Trd": "Trapezoid", "Para": "Parallelepiped",
    "Lambert": "matte", "lambert": "matte",
    "Asphere": "Quadric", "AsphericSurface": "Quadric", "XCone": "EllipticCone",
    "YCone": "EllipticCone", "ZCone": "EllipticCone", "RightCircularCylinder": "Cylinder",
    "RectangularParallelepiped": "Box", "TriangleMesh": "Triangles", "World": "Scene", "RaycastingScene": "Scene",
}  # fmt: skip
"""Classes and functions as they are called elsewhere, and the ones here."""
_PACKAGE_NAME_HINTS = {
    **dict.fromkeys(("loads", "from_string", "parse", "load_yaml", "from_yaml", "from_dict"),
                    "scenes are read from files, co.load(path), YAML or JSON"),
    **dict.fromkeys(("dumps", "to_yaml", "to_string", "to_json"), "scenes are written to files, scene.save(path)"),
    **dict.fromkeys(("Vector", "Vec3", "vec3", "Point", "Vector3", "Point3", "Vector3D", "Point3D", "Normal3D",
    "array"),
                    "vectors are three numbers, as a tuple, a list or an array"),
    **dict.fromkeys(("Color", "RGB", "rgb", "color"), "colours are texts, 'tomato', or three linear numbers"),
    **dict.fromkeys(("Aperture",), "an aperture is co.Stop(aperture, diameter)"),
    **dict.fromkeys(("Shell", "HollowSphere", "SphericalShell"), "that is co.SphereSection(outer, inner)"),
    **dict.fromkeys(("Torus",), "bodies are made of planes and quadrics, nothing else"),
    **dict.fromkeys(("Fresnel", "fresnel_equations"),
                    "co.refract has directions, and co.optics.fresnel the amounts by polarisation"),
    **dict.fromkeys(("Optic", "Surface", "SurfaceGroup", "Singlet"),
                    "lenses are solids, co.Sphere(r, a) & co.Sphere(r, b), and docs/tutorials/optics.md follows rays "
                    "through them"),
    **dict.fromkeys(("project", "projection", "sinogram", "radon", "forward_project"), "co.ct.project makes sinograms"),
    **dict.fromkeys(("Source", "PointSource", "Beam", "Detector", "Sensor", "Film"),
                    "sources are co.Rays(origins, directions), and detectors shapes that they hit"),
    **dict.fromkeys(("load_dict", "load_file", "load_scene", "read_scene"),
    "co.load(path) reads scene files, YAML or JSON"),
    **dict.fromkeys(("trimesh", "creation", "primitives", "Node", "Ray3f", "variants", "Plotter"),
                    "shapes are co.Sphere(...), co.Box(...) and so on, put in one list, co.Scene([...])"),
    **dict.fromkeys(("rotate_x", "rotate_y", "rotate_z"), 'shapes have motions, shape.rotate("z", degrees)'),
    **dict.fromkeys(("info", "describe", "summary"), "`conicoid info scene.yaml` lists what is in a scene file"),
    **dict.fromkeys(("Hemisphere",), "that is co.SphereSection(r, polar_range=(0, 90))"),
    **dict.fromkeys(("HexagonalPrism", "HexPrism", "Hexagon"), "that is co.RegularPrism(6, radius)"),
    **dict.fromkeys(("HollowCone", "ConicalTube", "ConeSegment"),
                    "that is co.Polycone([(z, inner, outer), (z, inner, outer)])"),
    **dict.fromkeys(("Ring", "Annulus"), "that is co.Disc(center, normal, r) - co.Cylinder(start, end, hole)"),
    **dict.fromkeys(("Capsule",), "that is a co.Cylinder united with a co.Sphere at each end"),
    **dict.fromkeys(("Cell", "Universe", "Lattice", "Geometry", "RectLattice", "HexLattice", "Settings", "Nuclide"),
                    "a cell is a co.Body of a region; co.load_openmc(path) reads whole models"),
    **dict.fromkeys(("XPlane", "YPlane", "ZPlane"), "the inside of -plane is co.HalfSpace(normal, offset)"),
    **dict.fromkeys(("XCylinder", "YCylinder", "ZCylinder"),
                    "co.Cylinder(start, end, radius) has ends, co.EllipticCylinder(1 / r**2, 1 / r**2) has none"),
    **dict.fromkeys(("seed", "set_seed"), "what is random takes a seed, scene.render(seed=1)"),
    **dict.fromkeys(("show", "plot", "display"), "pictures show themselves, scene.render().show()"),
}  # fmt: skip
"""What stands for names that are no class and no function here."""
_NAME_CUTOFF = 0.75
"""How much a name has in common with the one that may be meant, at least."""
_TRACE_SYNONYMS = ("intersect", "intersects", "intersection", "trace", "cast", "raycast", "shoot", "hit")
_LIST_METHODS = ("add", "append", "extend", "insert", "remove", "add_body", "add_shape")
_MOTIONS = ("translate", "rotate", "scale", "transform", "move")


def shape_attribute_error(thing: object, name: str) -> AttributeError:
    """The error for an attribute that a shape or a body does not have, which says where it is."""
    kind = type(thing).__name__
    return _attribute_error(
        thing, name, _shape_hint(kind.lower(), name) or (_body_hint(thing, name) if kind == "Body" else "")
    )


def _shape_hint(it: str, name: str) -> str:
    if name in SCENE_METHODS:
        return f"a scene has, co.Scene({it}).{name}(...)"
    if name in MEASURE_FIELDS:
        return f"co.measure({it}).{name} is that"
    if name in PACKAGE_FUNCTIONS:
        return f"it is a function, co.{name}({it})"
    if name in ("center", "centre") and it == "body":
        return "body.shape.center, or co.measure(body).centroid, is that"
    if name in ("center", "centre", "mass", "surface_area", "center_of_mass"):
        return f"co.measure({it}) has volume, area, centroid and inertia"
    if name in SHAPE_SYNONYMS:
        return f"it is called {SHAPE_SYNONYMS[name]}"
    if name in ("rotate_x", "rotate_y", "rotate_z", "rotateX", "rotateY", "rotateZ"):
        return f'axes are named, {it}.rotate("{name[-1].lower()}", degrees)'
    if name in ("mirror", "mirrored", "reflect", "flip", "reflected", "inverted"):
        return f"{it}.scale((-1, 1, 1)) is the mirror image across the plane x = 0, about=... across another"
    if name in _OPERATOR_SYNONYMS and it != "body":
        return f"shapes combine with operators, {it} {_OPERATOR_SYNONYMS[name]} other"
    if name in ("replace", "copy", "_replace", "set", "with_") and it != "body":
        return f"dataclasses.replace({it}, field=...) is another; shapes do not change"
    if name in _BODY_FIELDS and it != "body":
        return f"a body has that, co.Body({it}, material, name)"
    if it in ("union", "intersection", "difference", "complement", "painted"):
        part = "operand" if it in ("complement", "painted") else "operands[0]"
        return f"{it}.{part} is a shape that it is made of" if name in _OPERAND_FIELDS else ""
    return ""


def _body_hint(body: Any, name: str) -> str:
    """What the shape or the material of a body has."""
    for part in ("shape", "material"):
        found = vars(body).get(part)
        if not name.startswith("_") and (hasattr(type(found), name) or name in getattr(found, "__dict__", ())):
            return f"body.{part}.{name} is that"
    if name in ("density", "mu", "properties", "id", "volume_fraction", "refractive_index"):
        return f"a material has that: body.material.properties[{name!r}], of co.matte(color, properties={{...}})"
    if name in ("number", "index", "body_id"):
        return "a scene numbers its bodies: scene.bodies.index(body), and hits.body and scene.body_at have numbers"
    if name in ("position", "location", "origin", "pos"):
        return "co.measure(body).centroid is its centre, body.shape.bounds the box around it"
    if name in ("replace", "_replace", "with_material", "with_name", "copy", "set_material", "with_shape"):
        return "dataclasses.replace(body, material=...) is another, scene.replace(which, material=...) a scene with it"
    if name in _OPERATOR_SYNONYMS:
        return f"shapes combine, co.Body(a.shape {_OPERATOR_SYNONYMS[name]} b.shape, material)"
    return ""


def scene_attribute_error(scene: Any, name: str) -> AttributeError:
    """The error for an attribute that a scene does not have."""
    hint = SCENE_HINTS.get(name, "")
    if hint:
        pass
    elif name in PACKAGE_FUNCTIONS:
        hint = f"it is a function, co.{name}(scene)"
    elif name in MEASURE_FIELDS:
        hint = f"co.measure(scene).by_material and co.measure(scene)[body] have {name}"
    elif name in _TRACE_SYNONYMS:
        hint = "rays are followed by first_hit, occluded, spans and crossings"
    elif name in _LIST_METHODS:
        rest = "scene.lights, scene.camera, scene.background, scene.domain"
        hint = f"scenes do not change: co.Scene([*scene.bodies, another], {rest}) and scene.replace(...) are new ones"
    elif name in _MOTIONS:
        hint = "shapes and bodies move, co.Scene([body.translate(offset) for body in scene.bodies])"
    elif name in ("ray", "get_rays", "generate_rays"):
        hint = "it is called rays(width, height)"
    elif name in ("copy", "with_camera", "set_camera", "update", "edit"):
        hint = "scenes do not change: scene.replace(camera=...), or name and shape, is another"
    elif name in ("shapes", "objects", "items", "names"):
        hint = "scene.bodies are the entries, each with shape, material and name"
    elif any(name == body.name for body in vars(scene).get("_bodies", ())):
        hint = f"a body is called so, scene[{name!r}]"
    elif not name.startswith("_"):
        close = closest_name(name, [known for known in dir(type(scene)) if not known.startswith("_")], _NAME_CUTOFF)
        hint = f"did you mean {close}?" if close else ""
    return _attribute_error(scene, name, hint)


class HintingType(type):
    """The class of classes that tell what they have instead of a name that other packages have."""

    if not TYPE_CHECKING:  # else checkers would let any name be asked for

        def __getattr__(cls, name: str) -> Any:
            hint = CLASS_METHOD_HINTS.get(cls.__name__, {}).get(name, "")
            text = f"type object {cls.__name__!r} has no attribute {name[:80]!r}{': ' if hint else ''}{hint}"
            raise AttributeError(text, name=name, obj=cls)


def package_name_hint(name: str) -> str:
    """What to tell of a name that the package does not have."""
    if name in (*SCENE_METHODS, "rays", "bounds", "bodies"):
        return f": a scene has it, scene.{name}"
    if name in (*_TRACE_SYNONYMS, "raytrace", "ray_trace", "cast_rays"):
        return ": scenes are asked, scene.first_hit(origins, directions)"
    if (motion := name.lower()) in _MOTIONS:
        return f": shapes have it, shape.{SHAPE_SYNONYMS.get(motion, motion)}(...)"
    if name in _PACKAGE_NAME_HINTS:
        return f": {_PACKAGE_NAME_HINTS[name]}"
    return f" (did you mean {CLASS_SYNONYMS[name]}?)" if name in CLASS_SYNONYMS else ""


_MODULE_SYNONYMS = {
    "conicoid.apps.ct": {
        "fan": "fanflat", "fan_beam": "fanflat", "fanbeam": "fanflat", "cone_beam": "cone", "conebeam": "cone",
        "conebeam3d": "cone", "parallel_beam": "parallel", "parallel2d": "parallel", "spiral": "helical",
        "astra": "from_astra", "sinogram": "project", "radon": "project", "forward": "project",
        "forward_project": "project", "fp": "project", "projection": "project", "scan": "cone",
    },
    "conicoid.parallel": {
        "Pool": "Processes", "ProcessPool": "Processes", "ProcessPoolExecutor": "Processes", "Executor": "Workers",
        "LocalCluster": "Processes",
    },
}  # fmt: skip
_MODULE_NAME_HINTS = {
    **dict.fromkeys(("fbp", "iradon", "backproject", "reconstruct", "backprojection", "FDK", "fdk"),
                    "sinograms are made here and not reconstructed: ASTRA, RTK and scikit-image do that"),
    **dict.fromkeys(("Client", "SSHCluster", "SLURMCluster"), "that is Dask's, and any of its clients is an executor="),
}  # fmt: skip


def module_attribute_error(module: str, name: str, known: Sequence[str]) -> AttributeError:
    """The error for a name that one of the package's public modules does not have."""
    meant = _MODULE_SYNONYMS.get(module, {}).get(name, "") or (
        "" if name.startswith("_") else closest_name(name, known, _NAME_CUTOFF)
    )
    hint = (
        f": {_MODULE_NAME_HINTS[name]}" if name in _MODULE_NAME_HINTS else f" (did you mean {meant}?)" if meant else ""
    )
    return AttributeError(f"module {module!r} has no attribute {name[:80]!r}{hint}", name=name)


def _attribute_error(thing: object, name: str, hint: str) -> AttributeError:
    kind = type(thing).__name__
    text = f"{kind!r} object has no attribute {name[:80]!r}{': ' if hint else ''}{hint}"
    return AttributeError(text, name=name, obj=thing)


_OPERATORS = {"+": "|", "*": "&", "|": "|", "&": "&", "-": "-"}


def operator_error(thing: object, operator: str, other: Any) -> TypeError | None:
    """The error for an operator that a shape or a body does not have; None where others may know it."""
    kind = type(thing).__name__
    if operator == "*" and isinstance(other, int | float):
        return TypeError(f"{kind}: * {other} is no operation, {kind.lower()}.scale({other}) changes its size")
    if operator == "+" and other == 0 and isinstance(other, int):
        return TypeError(f"{kind}: sum() adds nothing up here, co.Union([...]) unites many")
    if operator in "+-" and isinstance(other, tuple | list | np.ndarray) and _is_number_triple(other):
        return TypeError(f"{kind}: {operator} {other} is no operation, {kind.lower()}.translate(offset) moves it")
    operands = {getattr(type(one), "operand_kind", "") for one in (thing, other)}
    if "" in operands:
        return None
    if "body" in operands:
        combined = f"a.shape {_OPERATORS[operator]} b.shape"
        return TypeError(f"Body: bodies do not combine, shapes do: co.Body({combined}, material)")
    return TypeError(
        f"{kind}: {operator} is no operation of shapes; a | b is the union, a & b what both have in common"
    )


def _is_number_triple(values: Any) -> bool:
    return len(values) == 3 and all(isinstance(value, int | float | np.number) for value in values)
