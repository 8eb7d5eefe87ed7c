"""The shaders and the Python code of the page give the package's answers."""

import re
from pathlib import Path

import numpy as np
import pytest

from conicoid.viewer import html
from conicoid.viewer.html import asset

from ..engine.test_ties import CENTERS, walls_along
from ..machine_code import needs_compiler
from .browser import needs_browser
from .mirrors import bodies, cells, looks, surfaces
from .mirrors.case import disagreements, evaluator
from .mirrors.markdown import PAGE, tables, written
from .mirrors.table import MIRRORS, NO_MIRROR, OTHER_NAMES, python_name
from .mirrors.worlds import exact_world, random_world, tied_trees, tied_world

# --- Each function of the shaders against the Python function that it mirrors

TOGETHER = {
    "surfaces": surfaces.CASES,
    "bodies": cells.CASES | bodies.CASES,
    "looks": looks.CASES,
    "walls": bodies.DEAR_CASES,
}


def trouble(bench, name, case, make_world, inputs_of, evaluate):
    """Return the faults of a case, in words."""
    world = make_world()
    inputs = inputs_of(world, np.random.default_rng(3))
    bench.load(world)
    found = bench.run(case.glsl, inputs, case.answers, case.sizes, case.view)
    rows, expected, decided = disagreements(name, case, world, inputs, found, evaluate)
    where = f"{name}, {make_world.__name__}: "
    if decided < case.decided:
        return [f"{where}only {decided:.0%} of the inputs are decided"]
    if len(rows) == 0:
        return []
    lines = [f"{where}{len(rows)} of {len(inputs)} answers differ; input, the shader's answers, Python's:"]
    for i in rows[:3]:
        lines += [str(inputs[i].tolist()), f"    {found[i].tolist()}", f"    {expected[i].tolist()}"]
    return lines


@needs_browser
@needs_compiler
@pytest.mark.parametrize("group", ["surfaces", "bodies", "looks", pytest.param("walls", marks=pytest.mark.deep)])
def test_the_shaders_answer_as_python_does(workbench, group):
    evaluate = evaluator(TOGETHER[group])
    troubles = [line for name in TOGETHER[group] for line in troubles_of(workbench, group, name, evaluate)]
    assert not troubles, "\n".join(troubles)


def troubles_of(bench, group, name, evaluate):
    """Return the faults of a case in both worlds."""
    case = TOGETHER[group][name]
    found = trouble(bench, name, case, random_world, case.inputs, evaluate)
    if case.exact_inputs is not None:
        found += trouble(bench, name, case, exact_world, case.exact_inputs, evaluate)
    return found


@needs_browser
def test_a_crossing_has_the_face_of_a_leaf_that_turns_the_body(workbench):
    """Walls of several leaves coincide and some are cut away: by unit cubes, as in tests/engine/test_ties.py."""
    rng, inputs, expected = np.random.default_rng(19), [], []
    for number, (tree, _) in enumerate(tied_trees()):
        for axis, row in ((axis, rng.integers(0, 6, 2)) for axis in range(3) for _ in range(8)):
            walls = walls_along(tree, axis, row)
            origin = [*np.insert(CENTERS[row], axis, -2.0), 0]
            inputs.append([origin, [*np.eye(3)[axis], 1e30], [-1, 0, 0, 0], [number, 0, 0, 0]])
            expected.append([1, *map(int, walls[0])] if walls else [0, 0, 0])
    workbench.load(tied_world())
    found = workbench.run(bodies.ENTRY_GLSL, np.array(inputs, np.float32), 6)
    assert found[:, [0, 2, 4]].tolist() == expected


MISTAKES = [
    ("surfaces", "roots_of", "quadric", "discriminant > 1e-36", "discriminant >= 0.0"),
    ("surfaces", "roots_of", "quadric", "b < 0.0 ? -root : root", "root"),
    ("surfaces", "roots_of", "quadric", "a == 0.0 && !crosses && c < 0.0", "a == 0.0 && !crosses && c > 0.0"),
    ("surfaces", "roots_of", "quadric", "(q < 0.0 ? -FAR : FAR)", "FAR"),
    ("surfaces", "sphere_roots", "quadric", "dot(p, p) - r * r", "dot(p, p) - r"),
    ("surfaces", "sphere_roots", "quadric", "float c = starts ? 0.0 : dot(p, p) - r * r", "float c = dot(p, p) - r * r"),
    ("surfaces", "quadric_roots", "quadric", "(g * g + 2.0 * h)", "(g * g + h)"),
    ("surfaces", "quadric_roots", "quadric", "float discriminant = starts ? b * b : (a * q.k", "float discriminant = (a * q.k"),
    ("surfaces", "curved_roots", "quadric", "bool starts = surface == ray.start", "bool starts = false"),
    ("surfaces", "quadric_gradient", "quadric", "x - q.anchor) + q.b", "x - q.anchor)"),
    ("surfaces", "normal_at", "traverse", "n = quadric.w2", "n = quadric.w1"),
    ("surfaces", "normal_at", "traverse", "return float(side) * normalized(n)", "return normalized(n)"),
    ("surfaces", "plane_values", "cell", "surface == ray.start ? 0.0 : ", ""),
    ("surfaces", "plane_crossing", "cell", "clamp(-height / rate,", "clamp(height / rate,"),
    ("surfaces", "inside_loop", "polygon", "(a.y < 0.0) != (b.y < 0.0)", "(a.y <= 0.0) != (b.y <= 0.0)"),
    ("surfaces", "inside_loop", "polygon", "low.x * high.y - high.x * low.y > 0.0", "low.x * high.y - high.x * low.y >= 0.0"),
    ("surfaces", "inside_loop", "polygon", "(d.x >= d.y ? 0 : 1)", "(d.x >= d.y ? 1 : 0)"),
    ("surfaces", "push_node", "walk", "near = vec4(first), far = vec4(last)", "near = vec4(0.0), far = vec4(last)"),
    ("surfaces", "push_node", "walk", "stack_t[slot - 1] < t", "stack_t[slot - 1] > t"),
    ("bodies", "clip_slab", "cell", "(rate < 0.0) == inner", "(rate < 0.0) != inner"),
    ("bodies", "clip_slab", "cell", "t < slab.t_out", "t <= slab.t_out"),
    ("bodies", "slab_of", "cell", "if ((height <= 0.0) != inner) return NOWHERE", "if ((height < 0.0) != inner) return NOWHERE"),
    ("bodies", "slab_of", "cell", "t > slab.t_in", "t >= slab.t_in"),
    ("bodies", "compose_spans", "cell", "high >= slab.t_in ? curved", "high > slab.t_in ? curved"),
    ("bodies", "compose_spans", "cell", "some = slab.t_in < out1", "some = slab.t_in <= out1"),
    ("bodies", "cell_spans", "cell", "low >= slab.t_in ? curved", "low > slab.t_in ? curved"),
    ("bodies", "cell_spans", "cell", "high <= slab.t_out ? curved", "high < slab.t_out ? curved"),
    ("bodies", "cell_spans", "cell", "low <= slab.t_out ? curved", "low < slab.t_out ? curved"),
    ("bodies", "cell_spans", "cell", "one.in1 < one.out1 ? 1 : 0", "one.in1 <= one.out1 ? 1 : 0"),
    ("bodies", "cell_spans", "cell", "more = in2 < slab.t_out", "more = in2 <= slab.t_out"),
    ("bodies", "cell_spans", "cell", "roots.outside != (number_and_side(row.y).y < 0)", "roots.outside"),
    ("bodies", "ball_spans", "cell", "roots.crosses, false, NO_PLACE", "roots.crosses, true, NO_PLACE"),
    ("bodies", "ball_spans", "events", "ball >= 0 && place != CUT_PLACE ? ball : place_face(place).x", "place_face(place).x"),
    ("bodies", "turn_leaf", "program", "rises = after != (row.z == 1)", "rises = after"),
    ("bodies", "turn_leaf", "program", "bool before = count >= row.y", "bool before = count > row.y"),
    ("bodies", "put_event", "events", "key <= taken_key", "key < taken_key"),
    ("bodies", "put_event", "events", "event_key[i] > key)", "event_key[i] < key)"),
    ("bodies", "gather", "events", "put_event(s.out2, 4 * leaf + 3, s.place_out2)", "put_event(s.out2, 4 * leaf + 3, s.place_out1)"),
    ("bodies", "counts_in", "events", "t < t_max && !(t == 0.0", "t <= t_max && !(t == 0.0"),
    ("bodies", "counts_in", "events", "&& !(t == 0.0 && starts)", ""),
    ("bodies", "surface_of", "events", "if (t != 0.0) return NO_SURFACE;", ""),
    ("bodies", "region_crossing", "program", "if ((counts[gate - first_gate] >= row.y) != rises) return false;", ""),
    ("bodies", "region_crossing", "events", "if (leaf_decides(integer4(LEAVES, event_key[k] >> 2), (event_key[k] & 1) == 1))", ""),
    ("bodies", "region_crossing", "events", "(bits & 1u) == 1u && fits && leaf_decides(leaf, on)", "(bits & 1u) == 1u && fits"),
    ("bodies", "region_crossing", "events", "entered ? any.y : -any.y", "any.y"),
    ("bodies", "region_crossing", "events", "now != inside && group < high", "now != inside && group <= high"),
    ("bodies", "region_crossing", "events", "else if (!(group == 0.0 && place_face(face.x).x == ray.start))", "else"),
    ("bodies", "region_crossing, closed", "events", "if (mode != CLOSED || on || t < ray.t_min)", ""),
    ("bodies", "entry_crossing", "events", "(sheet.one_sided && !against)", "false"),
    ("bodies", "entry_crossing", "events", "(falls != (k == 1)) == (sheet.side > 0)", "falls == (sheet.side > 0)"),
    ("bodies", "entry_crossing, sides", "events", "(a < ray.t_min && ray.t_min <= b)", "(a < ray.t_min && ray.t_min < b)"),
    ("bodies", "entry_crossing, sides", "events", "if (group < ray.t_min) result.before = now;", "result.before = now;"),
    ("bodies", "entry_crossing, chords", "events", "if (now) chord_from = group;", "if (!now) chord_from = group;"),
    ("bodies", "comes_first", "traverse", "t == other_t && rank < other_rank", "t == other_t && rank > other_rank"),
    ("bodies", "traverse", "traverse", "t == other_t && rank < other_rank", "t == other_t && rank > other_rank"),
    ("bodies", "traverse", "traverse", "best.t + abs(best.t) * 1e-6 + 1e-30", "best.t * 1.000001"),
    ("bodies", "traverse", "traverse", "mode == NOTICED && (flags", "(flags"),
    ("walls", "traverse, noticed", "traverse", "mode == NOTICED && (flags & OPAQUE) == 0 ? body | (1 << 30) : body", "body"),
    ("walls", "traverse, noticed", "materials", "if (before == after) return true;", "return before == after;"),
    ("bodies", "traverse, media", "traverse", "body < best.media.y", "body > best.media.y"),
    ("bodies", "traverse, blocked", "traverse", "mode == BLOCKED && (flags & OPAQUE) == 0", "false"),
    ("looks", "turns", "traverse", "if (y == 0.0) return x < 0.0 ? 0.5 : 0.0;", ""),
    ("looks", "uv_at", "traverse", "0.5 * p.z / length(p) + 0.5", "0.5 * p.z / length(p)"),
    ("looks", "material_row", "materials", "if (own_row >= 0) return own_row;", ""),
    ("looks", "surface_color", "materials", "- 1.220703125e-4 * n", "+ 1.220703125e-4 * n"),
    ("looks", "unseen", "materials", "&& wall.specular == vec3(0.0)", ""),
    ("looks", "unseen", "materials", "&& absorption_of(before) == absorption_of(after)", ""),
    ("looks", "unseen", "materials", "if (before == after) return true;", ""),
    ("looks", "absorbed", "materials", "|| length_inside <= 0.0", ""),
    ("looks", "background_color", "materials", "dz > 0.0 ? u_sky[0] : u_sky[2]", "dz < 0.0 ? u_sky[0] : u_sky[2]"),
    ("looks", "dielectric", "materials", "cos2 < 0.0 || (cos1", "(cos1"),
    ("looks", "opaque_reflectance", "materials", "(k * k * k * k * k)", "(k * k * k * k)"),
    ("looks", "refracted", "materials", "- cosine * n, cosine)", "+ cosine * n, cosine)"),
    ("looks", "wall_reflectance", "materials", "min(index1, index2) / max(index1, index2)", "index1 / index2"),
    ("looks", "towards", "lights", "light.position - x", "x - light.position"),
    ("looks", "share", "lights", "s * s * (3.0 - 2.0 * s)", "s"),
    ("looks", "share", "lights", "1.0 / (distance * distance)", "1.0 / distance"),
    ("looks", "highlight", "lights", "m.half_vector ? n : eye", "n"),
    ("looks", "light_at", "lights", "m.diffuse == 0.0 && shine < FAINT_SHINE ? 0.0 : ", ""),
    ("looks", "light_at", "lights", "if (cosine <= 0.0) return", "if (cosine <= -9.0) return"),
    ("looks", "push", "whitted", "< FAINT ||", "<= FAINT ||"),
    ("looks", "camera_ray", "camera", "v = (2.0 * pixel.y - u_size.y) / u_size.y", "v = (2.0 * pixel.y - u_size.y) / u_size.x"),
]  # fmt: skip
"""(group, case, piece, a text in it, the same with a slip of the pen)"""


def test_mistakes_are_in_the_shaders():
    """The mistakes are texts of the shaders, which a rewrite of these must move along."""
    for group, name, piece, right, _ in MISTAKES:
        assert name in TOGETHER[group], name
        assert right in asset(f"shaders/{piece}.glsl"), (piece, right)


@pytest.mark.deep
@needs_browser
@pytest.mark.parametrize("group", TOGETHER)
def test_mistakes_are_found(workbench, group):
    """A comparison is worth as much as the mistakes that it finds."""
    evaluate, not_found = evaluator(TOGETHER[group]), []
    workbench.load(random_world())
    for its, name, piece, right, wrong in MISTAKES:
        if its != group:
            continue
        text = asset(f"shaders/{piece}.glsl")
        workbench.rewrite(piece, text.replace(right, wrong))
        if not troubles_of(workbench, group, name, evaluate):
            not_found.append((name, right, wrong))
        workbench.rewrite(piece, text)
    assert not not_found, "\n".join(map(str, not_found))


# --- The table of mirrors is complete, in the tests and in the documentation

SHADERS = Path(html.__file__).parent / "shaders"
FUNCTION = re.compile(r"^\w+ (\w+)\([^;{]*\) \{", re.MULTILINE)
CASES = surfaces.CASES | cells.CASES | bodies.CASES | bodies.DEAR_CASES | looks.CASES


def functions():
    return {name for path in SHADERS.glob("*.glsl") for name in FUNCTION.findall(path.read_text(encoding="utf-8"))}


def test_every_function_is_in_the_table():
    """Each has its mirror or a reason for none, and nothing else is in the table."""
    assert functions() == MIRRORS.keys() | NO_MIRROR.keys()
    assert not MIRRORS.keys() & NO_MIRROR.keys()
    assert all(NO_MIRROR.values())


def test_every_file_is_a_piece_of_a_shader():
    assert {path.stem for path in SHADERS.glob("*.glsl")} == html.shaders()["pieces"].keys()


def test_every_mirror_is_tried():
    """Each has a case of its own name, or of the name in the table, which calls it."""
    for name, mirror in MIRRORS.items():
        assert (mirror.case or name) in CASES, name
    assert {name.partition(",")[0] for name in CASES} <= MIRRORS.keys()


def test_the_names_are_pythons():
    """Names of functions with their own case are Python's. Other names have a reason."""
    for name, mirror in MIRRORS.items():
        names = {python_name(function).rpartition(".")[2] for function in mirror.python}
        if not mirror.case and name not in OTHER_NAMES:
            assert name in names, f"{name} mirrors {names}"
    assert MIRRORS.keys() >= OTHER_NAMES.keys()


def test_the_documentation_has_the_table():
    """`python -m tests.viewer.mirrors.markdown` writes it anew."""
    text = PAGE.read_text(encoding="utf-8")
    assert text == written(text)
    assert tables() in text
