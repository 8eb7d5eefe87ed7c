"""What is asked of answers, rays, materials, measures, pictures and cameras by names that other systems have."""

from __future__ import annotations

from typing import Any, TypeVar

from .suggestion import close_to

Kind = TypeVar("Kind", bound=type)
_ALIKE = 0.75
_SHOWN = 80


def _all(hint: str, names: str) -> dict[str, str]:
    return dict.fromkeys(names.split(), hint)


_FIELDS = _all("its fields are arrays and have that: {0}.{1}.{2}()", "min max mean sum std argmin argmax")
_SHAPE = _all(
    "it has the shape of its rays: ask with rays of another, or reshape a field, {0}.{1}.reshape(...)",
    "reshape ravel flatten squeeze T transpose",
)
_TABLE = _all(
    "{0}.save(path) writes a .npz file; the fields are arrays for any table, such as {0}.{1}",
    "to_csv to_dataframe to_pandas to_dict to_numpy tolist to_list save_csv",
)
_BODIES = {
    **_all(
        "it is called body, the number of each; {0}.name and {0}.material are what scene.body(number) has",
        "bodies body_id body_ids ids id obj object objects index indices primitive geom_id geomID",
    ),
    **_all("it is called name", "names label labels"),
    **_all("materials have that: {0}.material, and .color of each", "color colors colour"),
    **_all("materials keep that: {0}.material, and .properties of each", "properties density"),
}


def _of_rays(name: str) -> dict[str, str]:
    plain = f"rays.{name}s"
    return {f"{name}s": f"{{0}}.{plain} is that", name: f"{{0}}.{plain} is that"}


_NAMES: dict[str, dict[str, str]] = {
    "Hits": {
        **_all("hits[mask] selects, as hits[hits.hit]", "filter where select first nonzero head"),
        **_all("it is called name, and scene.body(number) is the body of one", "body_name body_names"),
        **_all("it is called face, the number within the body", "primID primitive_ids prim_ids triangle_id index_tri"),
        **_all("it is called body, the number of each", "geometry_ids geometry_id geomid instID instance"),
        **_all(
            "it is called rays, hits.rays[i] is one",
            "ray_index index_ray ray_ids dir incident wo wi ray ray_directions",
        ),
        **_all(
            "-(hits.rays.directions * hits.normal).sum(-1) is the cosine, where directions are unit",
            "cos cosine angle angles incidence angle_of_incidence cos_theta theta incidence_angle",
        ),
        **_all("triangles have (β, γ) in uv", "barycentric barycentrics primitive_uvs"),
        **_all(
            "a scene is asked again: scene.first_hit(hits.spawn(directions))", "to_world offset continue_ spawn_ray"
        ),
        **_all("the scene is where it was asked, hits keep its names and materials", "scene"),
        **_all("the fields are t, point, normal, body, face, surface, uv and more", "keys fields columns items values"),
        **_all("hits.hit.sum() is how many rays hit, len(hits) how many there are", "count n_hits num_hits"),
        **_all("scene.contains(points) tells that", "is_inside contains"),
        **_all("hits[np.argsort(hits.t)] are in the order of t", "sort sorted argsort sort_values"),
        **_FIELDS,
        **_SHAPE,
        **_TABLE,
        **_BODIES,
        **_of_rays("origin"),
        **_of_rays("direction"),
        **_all(
            "it is called point", "points position positions location locations hit_point intersection p xyz coords"
        ),
        **_all(
            "hits.t is that, in units of the length of the direction", "distance distances depth dist tfar tnear tmin"
        ),
        **_all("it is called normal", "normals n N normal_vector Ng"),
        **_all("it is called face", "faces face_id prim_id"),
        **_all(
            "it is called hit, true where there was one, and ~hits.hit",
            "mask valid is_hit hits found did_hit miss missed any all",
        ),
        **_all("~hits.entering is that, where hits.hit is true", "inside is_inside exiting leaving front_face"),
        **_all("it is called t_error, and point_error for the place", "error errors uncertainty"),
        **_all("it is called surface", "surfaces"),
        **_all("it is called material", "materials"),
        **_all("it is called uv, hits.uv[..., 0] is u", "u v texcoord"),
        **_all(
            "co.{2}(hits.rays.directions, hits.normal, ...) has directions, and hits.spawn(directions) the rays",
            "reflect refract",
        ),
        **_all(
            "hits.spawn(co.reflect(hits.rays.directions, hits.normal)) are the mirrored rays",
            "bounce reflected reflected_rays",
        ),
        **_all("scene.spans(rays) has that", "t_enter t_exit offsets lengths length thickness spans"),
        **_all("scene.crossings(rays) has all of them, not the first alone", "all_hits second next crossings"),
        **_all("hits.detached() stays without the scene; hits are read-only and need no copies", "copy"),
    },
    "Rays": {
        **_all("a scene is asked: scene.first_hit(rays).{2}", "t body normal hit_point uv face material"),
        **_all(
            "rays.origins + t[..., None] * rays.directions are points at t; of hits, hits.point",
            "at point_at points point evaluate position end",
        ),
        **_SHAPE
        | _all(
            "co.Rays(rays.origins.reshape(..., 3), rays.directions.reshape(..., 3)) are plain rays of another "
            "shape; rays[...] selects, rays[:, None] has one axis more",
            "reshape ravel flatten squeeze transpose T",
        ),
        **_all("it is called origins", "origin o org orig start starts position source"),
        **_all("it is called directions", "direction d dir dirs"),
        **_all("directions may have any length, and t is in units of it", "normalize normalized unit normalise"),
        **_all(
            "intervals go with the question: scene.first_hit(rays, t_min=0, t_max=9)",
            "t_min t_max tmin tmax tnear tfar mint maxt interval",
        ),
        **_all(
            "rays are arrays: co.Rays(rays.origins + offset, rays.directions)",
            "translate move rotate transform scale offset",
        ),
        **_all("co.Rays.concatenate([a, b]) joins rays", "append extend join concat stack"),
        **_all("a scene is asked, scene.{2}(rays)", "first_hit occluded spans crossings lengths line_integral"),
        **_all("a scene is asked, scene.first_hit(rays)", "trace cast intersect hit hits"),
        **_all("spawned rays know the surface that they start on by themselves", "surface surfaces start_surface"),
        **_all("rays are read-only and need no copies", "copy"),
        **_TABLE,
    },
    "Spans": {
        **_FIELDS,
        **_SHAPE,
        **_TABLE,
        **_BODIES,
        **_of_rays("origin"),
        **_of_rays("direction"),
        **_all(
            "spans.lengths() are true lengths, by ray and body",
            "length distance distances thickness path_length path_lengths chord chords chord_length total sum",
        ),
        **_all("it is called t_enter", "t0 start starts begin enter entry t_start t_in t_min tmin near"),
        **_all("it is called t_exit", "t1 end ends exit leave t_end t_out t_max tmax far"),
        **_all("the two ends of each are t_enter and t_exit", "t ts intervals segments"),
        **_all(
            "scene.crossings(rays) has point and normal of every end",
            "point points normal normals face faces surface entering",
        ),
        **_all("spans.lengths(by='material') is that", "by_material material_lengths lengths_by_material"),
        **_all("spans.line_integral(values) is the sum of value times length", "integral integrate weighted_sum"),
        **_all("np.diff(spans.offsets) has how many each ray has", "count counts n number size"),
        **_all("np.diff(spans.offsets) > 0 has which rays have any", "hit hits any mask"),
    },
    "Crossings": {
        **_FIELDS,
        **_SHAPE,
        **_TABLE,
        **_BODIES,
        **_of_rays("origin"),
        **_of_rays("direction"),
        **_all("crossings.t is that, in units of the length of the direction", "distance distances depth dist"),
        **_all("it is called point", "points position positions location"),
        **_all("it is called normal", "normals n"),
        **_all("scene.spans(rays) has that", "t_enter t_exit lengths length line_integral thickness"),
        **_all("scene.first_hit(rays) has that, of the first one", "uv local_point point_error"),
        **_all("it is called entering", "enter exit exiting leaving inside"),
        **_all("crossings.point are the places, and scene.first_hit(rays) has the first of each ray", "hits first"),
        **_all("np.diff(crossings.offsets) has how many each ray has", "count counts number size hit"),
    },
    "Material": {
        **_all(
            "it is called color, linear rgb or a text", "colour rgb diffuse_color albedo base_color kd Kd reflectance"
        ),
        **_all("it is called refractive_index", "ior n index eta refraction index_of_refraction"),
        **_all("it is called transparency", "alpha opacity transmission transmittance"),
        **_all("it is called shininess, the greater the smoother", "glossiness gloss exponent"),
        **_all("it is called specular", "specular_color ks Ks"),
        **_all("it is called reflectivity", "mirror reflection metallic"),
        **_all("it is called emission, the radiance of a surface", "emissive emitted glow light"),
        **_all(
            "dataclasses.replace(material, field=...) is another; materials do not change",
            "replace copy set update with_",
        ),
        **_all(
            "material.properties is a mapping of your own values, given as properties={{...}}",
            "density mu attenuation mass id data userdata user_data metadata Z sigma temperature set_density "
            "add_nuclide add_element add_nuclides",
        ),
    },
    "Measures": {
        **_all("volume times a density is that: measures.volume * material.properties['density']", "mass weight"),
        **_all("it is called centroid", "center centre center_of_mass com cog mean barycenter"),
        **_all("it is called area", "surface_area surface"),
        **_all(
            "it is called inertia, for density 1",
            "moment moments moment_of_inertia inertia_tensor moments_of_inertia I tensor",
        ),
        **_all(
            "each value has its own: volume_error, area_error, centroid_error, inertia_error",
            "error errors std sigma uncertainty",
        ),
        **_all("the shape has that, shape.bounds", "bounds bbox extent"),
        **_all("co.measure(scene).names are those of bodies, in the order of their measures", "name names body"),
        **_all("materials keep that, material.properties", "density"),
    },
    "SceneMeasures": {
        **_all(
            "each material and body has that: found.by_material[0].{2}, found['name'].{2}, found[0].{2}",
            "area area_error centroid centroid_error inertia inertia_error rays",
        ),
        **_all(
            "it is called volume, an array by body; found['name'].volume is that of a material or body", "volumes total"
        ),
        **_all(
            "the volume of each times its density is that: found.by_material goes with found.materials",
            "mass masses weight",
        ),
        **_all(
            "found['name'] has those of a material or body, found.by_material of all materials", "items keys values get"
        ),
    },
    "Image": {
        **_all(
            "image.pixels.shape is (height, width, 3); image.width and image.height are its sides",
            "shape size resolution dtype",
        ),
        **_all(
            "image.pixels is linear light, and np.asarray(image) the bytes that are shown",
            "array data numpy rgb to_numpy tolist astype",
        ),
        **_all("image.show() shows it, and image.save(path) writes it", "plot imshow display view write export"),
        **_all(
            "PIL.Image.fromarray(np.asarray(image)) is a picture of Pillow, whose save also takes a file in memory",
            "to_bytes tobytes bytes to_pil pil __array_interface__",
        ),
        **_all(
            "scenes are rendered in any size, and PIL.Image.fromarray(np.asarray(image)) is a picture to edit",
            "resize crop rotate convert thumbnail",
        ),
        **_FIELDS,
    },
    "Camera": {
        **_all("it is called field_of_view, in degrees", "fov fovy fov_y angle"),
        **_all("it is called position", "eye location origin center pos"),
        **_all("it is called look_at", "target lookat at focus"),
        **_all(
            "a Camera has aperture, the diameter of its lens, and focus_distance", "f_stop fstop f_number focal_length"
        ),
        **_all("a scene has it, scene.render(width, height, camera=camera)", "render picture shoot"),
        **_all(
            "dataclasses.replace(camera, position=...) is another camera; cameras do not change",
            "move translate rotate orbit zoom copy replace moved translated rotated pan dolly",
        ),
        **_all("it is worked out: look_at - position, at any length", "direction forward"),
        **_all("it is that of a picture: width / height of scene.render(width, height)", "aspect aspect_ratio width"),
        **_all("it is called rays(width, height)", "get_rays generate_rays ray"),
    },
}
_NAMES["SceneMeasures"] |= _all("found.volume.sum() is that of all bodies", "sum mean total_volume") | _all(
    "found.names, found.volume and found.bodies are columns of a table, and `conicoid measure` writes one as .csv",
    "to_csv to_dataframe to_pandas to_dict to_numpy tolist to_list save_csv save",
)
_NAMES["Classification"] = {
    **_all("they are called semi_axes", "radius radii half_axes semiaxes a b c"),
    **_all("it is called kind", "type name family"),
    **_all("it is called center", "centre vertex apex origin point"),
    **_all("they are called axes, and a body of revolution has its own last", "axis direction directions"),
    **_all("it is called revolution", "is_revolution symmetric"),
}
_NAMES["Finding"] = {
    **_all("a ray that shows it is finding.origin and finding.direction", "ray rays origins directions"),
    **_all("it is called message, and str(finding) is all of it", "text description msg reason info"),
    **_all("it is called size", "volume thickness length overlap extent"),
    **_all("it is called kind", "type category severity level"),
    **_all("it is called bodies, their numbers", "body names name ids"),
    **_all("it is called size_error", "error volume_error"),
    **_all("it is called point, for undefined regions; others have a ray, origin and direction", "position location"),
}
_NAMES["Molecule"] = {
    **_all("they are called symbols, and numbers the atomic numbers", "elements element symbol species atoms types"),
    **_all("it is called positions", "coordinates coords xyz points position"),
}
_NAMES["Paths"] = _all(
    "paths.wall and paths.body are numbers of bodies: scene.body(number).name is that of one", "name names material"
)
_NAMES["CameraRays"] = {
    **_all("rays.made().{2} is that: these rays are made where they are traced", "origins directions"),
    **_all("rays.made() are rays in arrays, which have that", "save concatenate copy origin direction reshape spawn"),
    **_all("a scene is asked, scene.{2}(rays)", "first_hit occluded spans crossings lengths line_integral"),
}
_NAMES["ScanRays"] = _NAMES["CameraRays"]
_NAMES["Geometry"] = {
    **_all("co.Rays.from_scan(geometry) are its rays", "rays get_rays directions origins ray pixels_rays"),
    **_all(
        "it is kept in vectors, twelve numbers a view, not as angles",
        "angles theta source_origin origin_detector pitch",
    ),
    **_all(
        "u and v in vectors, geometry.vectors[:, 6:9] and [:, 9:], are the steps of pixels", "spacing pixel_size offset"
    ),
    **_all("it is called views", "n_views num_views count projections"),
    **_all("co.ct.project(scene, geometry, values) is the sinogram", "project sinogram trace"),
    **_all("geometry.pixels(view, row, column) are centres to plot, vectors[:, :3] the sources", "plot show sources"),
}
_NAMES["OrthographicCamera"] = _NAMES["Camera"] | _all(
    "parallel rays have no angle; height is that of the window", "fov fovy field_of_view angle"
)
_NAMES["EquirectangularCamera"] = _NAMES["Camera"] | _all(
    "it sees all around, 360 by 180 degrees", "fov fovy field_of_view angle"
)
_NAMES["FisheyeCamera"] = _NAMES["Camera"]
_FIRST = {"Hits": "t", "Spans": "t_enter", "Crossings": "t", "Rays": "origins", "Image": "pixels"}


def hinted(kind: Kind) -> Kind:
    """A class that tells of names that it does not have what they are here."""
    setattr(kind, "__getattr__", _not_there)  # noqa: B010 (checkers would let any attribute be asked for)
    return kind


def _not_there(thing: object, name: str) -> Any:
    """The error for an attribute that there is not."""
    kind = type(thing).__name__
    hint = "" if name.startswith("_") and name not in _NAMES.get(kind, ()) else _hint(thing, kind, name)
    text = f"{kind!r} object has no attribute {name[:_SHOWN]!r}{': ' if hint else ''}{hint}"
    raise AttributeError(text, name=name, obj=thing)


def _hint(thing: object, kind: str, name: str) -> str:
    own = getattr(thing, "properties", None) if kind == "Material" else None
    if own is not None and name in own:
        return f"material.properties[{name!r}] is that"
    if name in _NAMES.get(kind, ()):
        return _NAMES[kind][name].format(kind.lower(), _FIRST.get(kind, ""), name)
    fields = [field for field in {*dir(type(thing)), *getattr(thing, "__dict__", ())} if not field.startswith("_")]
    close = close_to(name, sorted(fields), _ALIKE)
    return f"did you mean {close}?" if close else ""
