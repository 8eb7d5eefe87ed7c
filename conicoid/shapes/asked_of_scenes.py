"""What scenes of other packages are asked, and what answers it here."""

from __future__ import annotations


def _all(hint: str, names: str) -> dict[str, str]:
    return dict.fromkeys(names.split(), hint)


_CHANGED = "scenes do not change: scene.{0} is another scene"
ASKED = {
    **_all(
        "it is called first_hit(origins, directions), t of a miss being inf",
        "first_hits closest_hit closest_hits nearest nearest_hit closest ray_intersect ray_intersection cast_rays "
        "cast_ray intersects_first intersects_location intersects_id "
        "ray_trace raytrace trace_rays shoot_rays "
        "hits find_hit intersect_rays intersect_ray intersections multi_ray_trace ray_cast",
    ),
    **_all(
        "it is called occluded(origins, directions, t_max=1), where directions are target - origin",
        "visible is_visible visibility line_of_sight shadow in_shadow ray_test test_occlusions intersects_any any_hit "
        "is_occluded occlusion blocked",
    ),
    **_all("it is called explain(origin, direction)", "why debug_ray trace_one work_out show_ray inspect_ray"),
    **_all("it is called crossings(rays), all of each ray", "all_hits every_hit all_intersections intersects_all"),
    **_all("np.diff(scene.crossings(rays).offsets) has how many each ray has", "count_intersections count_hits"),
    **_all(
        "it is called lengths(rays), by body, or with by='material'",
        "path_lengths path_length ray_length ray_lengths chords chord_lengths thickness track_lengths distances",
    ),
    **_all(
        "it is called line_integral(values, rays)",
        "project projection optical_depth attenuation integrate radiograph sinogram transmission",
    ),
    **_all(
        "scene.body_at(points) has the numbers of bodies, and scene.body(number).material what one is made of",
        "material_at find find_cell cell_at which_body locate name_at inside_body point_in",
    ),
    **_all(
        "scene.bodies, scene.bounds, scene.materials and scene.memory are that; `conicoid info scene.yaml` prints them",
        "info describe summary statistics stats print report",
    ),
    **_all("scenes are asked by rays, scene.first_hit(origins, directions)", "query ask evaluate run"),
    **_all("it is called contains(points)", "contains_points compute_occupancy is_inside inside point_inside"),
    **_all(
        "scene.distance(points) is the distance from the nearest wall, with exact=True the nearest point",
        "signed_distance compute_distance compute_signed_distance closest_point closest_points "
        "compute_closest_points sdf",
    ),
    **_all("it is called bounds", "aabb aabbs bbox bounding_box box get_bounds get_aabb bbox_min limits"),
    **_all(
        "scene.bodies are the entries, and scene[name] one of them; scene.bodies.index(name) is its place",
        "number body_number "
        "get keys values body_index index body_names cells get_all_cells get_all_bodies children root_universe "
        "universe surfaces get_all_surfaces geometries meshes nodes entries find_body",
    ),
    **_all("it is called materials", "get_all_materials material_names mats"),
    **_all("it is called lights", "emitters light sources"),
    **_all("it is called camera, None for a scene without", "sensors sensor cameras view_point"),
    **_all("it is called background", "environment env sky world"),
    **_all(
        "it is called save(path)", "write to_yaml to_json to_file dump dumps export_yaml save_yaml to_string to_dict"
    ),
    **_all(
        "pictures are asked for: scene.render(width, height)", "render_image render_scene picture image draw capture"
    ),
    **_all("scene.render().show() shows a picture, scene.view() the scene", "show plot display imshow preview"),
    **_all("nothing is turned into triangles: surfaces are exact", "to_mesh mesh triangulate to_trimesh to_stl to_obj"),
    **_all(
        _CHANGED.format("added(items)"), "add_object add_objects add_sphere add_box add_triangles add_geometry add_mesh"
    ),
    **_all(_CHANGED.format("replace(lights=[...])"), "add_light add_lights set_lights"),
    **_all(_CHANGED.format("without(which)"), "delete pop clear drop discard"),
    **_all(
        "co.check(scene) finds overlaps, each with a ray", "overlaps find_overlaps overlapping is_watertight is_valid"
    ),
    **_all("it is called section(plane, at), or slice(plane, at=...)", "cut cross_section clip"),
    **_all("it is called voxels(bounds, shape)", "voxelize voxelise rasterize to_grid volume_fractions"),
    **_all(
        "scenes are put together by their entries, co.Scene([*a.bodies, *b.bodies], a.lights)",
        "union merge join combine concatenate",
    ),
}
"""Names of Raysect, Mitsuba, Open3D, trimesh, PyVista and OpenMC, and of no package at all, and what there is here."""
OF_CLASSES = {
    "Scene": _all("co.load(path) reads a scene file", "from_yaml from_file read open from_json parse loads from_string")
    | _all("co.load_openmc(path) reads OpenMC's geometries", "from_openmc from_xml load_openmc")
    | _all("what a scene is made of is handed to it, co.Scene([bodies], lights, camera)", "from_dict from_list create"),
    "Image": _all(
        "images are made of arrays, co.Image(np.asarray(PIL.Image.open(path)))", "load open read from_file imread"
    )
    | _all("images are made of arrays, co.Image(array)", "fromarray from_array frombytes"),
    "Rays": _all(
        "directions are differences, co.Rays(origins, targets - origins)", "from_points between look_at to towards"
    )
    | _all("it is called concatenate([a, b])", "stack concat join merge append hstack vstack")
    | _all("it is called load(path)", "from_file from_npz from_csv from_npy read open"),
    "Hits": _all("it is called load(path)", "from_file from_npz read open")
    | _all("it is called concatenate([a, b])", "stack concat join merge"),
}
"""What classes of other packages are asked, such as `Scene.from_yaml`."""
