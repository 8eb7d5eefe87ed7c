"""Undefined regions: points of a model that are in no cell."""

import copy
import math
import pickle
from pathlib import Path

import numpy as np
import pytest

import conicoid as co
from conicoid.apps.checks.probe_rays import ProbeTargets
from conicoid.apps.checks.undefined_regions import UndefinedRegions, undefined_regions

from ..command_line import run
from ..formats.openmc.models import EXAMPLE_FILES, geometry_file, load_model
from ..samples import sampled

PI = math.pi
MODEL = """<geometry>
<surface id="1" type="z-cylinder" coeffs="0 0 0.4"/><surface id="2" type="z-cylinder" coeffs="0 0 {0}"/>
<surface id="3" type="z-plane" coeffs="0"/><surface id="4" type="z-plane" coeffs="2"/>
<surface id="5" type="z-cylinder" coeffs="0 0 {1}" boundary="vacuum"/>
<cell id="1" universe="1" material="1" region="-1"/><cell id="2" universe="1" material="2" region="2"/>
<cell id="3" universe="2" material="{2}" />
<lattice id="7" dimension="2 2" lower_left="-1 -1" pitch="1 1" universes="1 2 2 1">{3}</lattice>
<cell id="4" fill="7" region="-5 3 -4"/></geometry>"""


def model(
    folder: Path, gap: float = 0.4, reach: float = 0.9, material: str = "void", outer: str = "<outer>2</outer>"
) -> Path:
    return geometry_file(MODEL.format(gap, reach, material, outer), folder)


def undefined_findings(scene: co.Scene, **options: int) -> list[co.checks.Finding]:
    return [finding for finding in co.check(scene, **{"rays": 6000, **options}) if finding.kind == "undefined"]


def test_a_gap_in_a_pin_is_found_wherever_the_pin_stands(tmp_path):
    """The space between the radii 0.4 and 0.5 is undefined in two of the four elements."""
    scene = co.load_openmc(model(tmp_path, gap=0.45, reach=3.0))
    found = undefined_findings(scene)
    assert len(found) == 2
    for finding in found:
        assert scene.body_at(finding.point) == -1
        x, y, z = finding.point
        assert 0 < z < 2
        assert 0.4 < math.hypot(abs(x) - 0.5, abs(y) - 0.5) < 0.45
        assert finding.size == pytest.approx(PI * (0.45**2 - 0.4**2) * 2, rel=0.3)  # by a few thousand points
        assert len(scene.spans(finding.origin, finding.direction).body) > 0
        assert "is in the scene's domain but in no body; the region beside bodies" in finding.message
        assert "cell 1" in finding.message
    assert np.sign(found[0].point[:2]).tolist() != np.sign(found[1].point[:2]).tolist()


def test_beyond_a_lattice_without_an_outer_universe(tmp_path):
    scene = co.load_openmc(model(tmp_path, reach=1.25, outer=""))
    found = undefined_findings(scene)
    assert found
    assert max(abs(found[0].point[0]), abs(found[0].point[1])) > 1
    segment = 1.25**2 * math.acos(1 / 1.25) - math.sqrt(1.25**2 - 1)
    assert sum(finding.size for finding in found) == pytest.approx(4 * segment * 2, rel=0.3)


@pytest.mark.parametrize("material", ["void", "3"])
@pytest.mark.parametrize("reach", [0.9, 3.0])
def test_void_regions_count_as_defined(material, reach, tmp_path):
    """Universe 2 is void or matter, in the lattice and around it."""
    scene = co.load_openmc(model(tmp_path, reach=reach, material=material))
    assert scene.domain is not None
    assert undefined_findings(scene) == []


def test_the_examples_are_whole():
    for path in EXAMPLE_FILES.values():
        scene = load_model(path)
        assert scene.domain is not None
        assert undefined_regions(scene, ProbeTargets.of(scene._prepared.lowered), 1000, np.random.default_rng(0)) == []


def test_omitted_void_is_not_searched(tmp_path):
    scene = co.load_openmc(model(tmp_path), void=False)
    assert scene.domain is None
    assert undefined_findings(scene) == []


def test_lattices_that_are_turned_have_no_gaps(tmp_path):
    """Walls of neighbours are equal in decimals. The slivers that rounding leaves between them are no regions."""
    path = model(tmp_path, reach=1.2)
    path.write_text(
        path.read_text().replace('<cell id="4"', '<cell id="4" rotation="10 20 33" translation="0.1 0.2 0.3"')
    )
    assert undefined_findings(co.load_openmc(path)) == []


BARE = """<geometry>
<surface id="1" type="z-cylinder" coeffs="0 0 0.4"/><surface id="2" type="z-cylinder" coeffs="0 0 0.45"/>
<surface id="3" type="z-plane" coeffs="0" boundary="reflective"/><surface id="4" type="z-plane" coeffs="2" boundary="{0}"/>
<surface id="5" type="x-plane" coeffs="-1" boundary="vacuum"/><surface id="6" type="x-plane" coeffs="1" boundary="vacuum"/>
<surface id="7" type="y-plane" coeffs="-1" boundary="vacuum"/><surface id="8" type="y-plane" coeffs="1" boundary="vacuum"/>
<cell id="1" material="1" region="-1 3 -4"/><cell id="2" material="2" region="2 3 -4 5 -6 7 -8"/>{1}</geometry>"""


def test_a_gap_between_cells_of_the_root(tmp_path):
    path = geometry_file(BARE.format("white", ""), tmp_path)
    (found,) = undefined_findings(co.load_openmc(path))
    assert 0.4 < math.hypot(*found.point[:2]) < 0.45
    assert found.size == pytest.approx(PI * (0.45**2 - 0.4**2) * 2, rel=0.3)


@pytest.mark.parametrize(
    ("top", "more"),
    [
        ("transmission", ""),  # the model is not enclosed
        ("white", '<cell id="3" material="void" region="-3"/>'),  # cells on both sides of a boundary
        ("white", '<cell id="3" material="void" region="1 -2 3 -4"/>'),  # the gap is filled
    ],
)
def test_no_gap_is_reported_without_boundaries(top, more, tmp_path):
    path = geometry_file(BARE.format(top, more), tmp_path)
    assert undefined_findings(co.load_openmc(path)) == []


def test_any_scene_may_name_the_region_to_be_filled():
    box = co.Box((0, 0, 0), (3, 1, 1))
    scene = co.Scene([co.Box((0, 0, 0), (1, 1, 1)), co.Box((2, 0, 0), (3, 1, 1))], domain=box)
    (found,) = undefined_findings(scene)
    assert found.bodies == (0, 1)
    assert found.size == pytest.approx(1, rel=0.05)
    assert 1 < found.point[0] < 2
    assert undefined_findings(co.Scene(scene.bodies)) == []
    (found,) = undefined_findings(co.Scene([], domain=box))
    assert found.size == pytest.approx(3, rel=0.05)
    assert found.bodies == ()
    with pytest.raises(TypeError, match="Scene: domain must be a solid or None, got Disc"):
        co.Scene([], domain=co.Disc((0, 0, 0), (0, 0, 1), 1))


def test_copies_keep_the_domain(tmp_path):
    scene = co.load_openmc(model(tmp_path, gap=0.45, reach=3.0))
    for again in (copy.copy(scene), copy.deepcopy(scene), pickle.loads(pickle.dumps(scene))):
        assert again == scene
        assert again.domain == scene.domain
    assert co.Scene(scene.bodies) != scene
    for suffix in (".yaml", ".json"):
        co.save(scene, tmp_path / f"scene{suffix}")
        assert co.load(tmp_path / f"scene{suffix}") == scene
    output = tmp_path / "imported.yaml"
    assert run("import", tmp_path / "geometry.xml", "-o", output).exit_code == 0
    result = run("info", output, "--check", "--rays", "6000")
    assert result.exit_code == 3
    assert result.stdout.count("undefined: (") == 2


def test_a_domain_in_a_file_is_a_solid(tmp_path):
    path = tmp_path / "scene.yaml"
    path.write_text("domain: {Disc: {center: [0, 0, 0], normal: [0, 0, 1], radius: 1}}\nbodies: []\n")
    with pytest.raises(co.SceneFileError, match="domain"):
        co.load(path)


def slab_with_gaps(*gaps: tuple[float, float], wide: float = 1.0) -> co.Scene:
    """Return a slab of width 1 with gaps along x, which all lie between the same two planes."""
    rest = co.Box((0, 0, 0), (10, wide, 1))
    for low, high in gaps:
        rest = rest - co.Box((low, -1, 0.25), (high, wide + 1, 0.75))
    return co.Scene(rest, domain=co.Box((0, 0, 0), (10, wide, 1)))


def test_gaps_beside_one_wall_are_distinguished():
    """Three holes with the same floor and the same ceiling are three regions, each with its own volume."""
    holes = (1.0, 2.0), (4.0, 4.5), (7.0, 9.0)
    found = undefined_findings(slab_with_gaps(*holes))
    for finding, (low, high) in zip(found, sorted(holes, key=lambda hole: hole[0] - hole[1]), strict=True):
        assert low < finding.point[0] < high
        assert 0.25 < finding.point[2] < 0.75
        assert abs(finding.size - (high - low) / 2) < 5 * finding.size_error
        assert 0 < finding.size_error < 0.05 * finding.size
        assert f" ± {finding.size_error:.1g}; seen by" in finding.message


def test_standard_errors_are_those_of_many_seeds():
    """The volume is within five sigma of its formula, and the scatter over seeds has the size of the errors."""
    scene = slab_with_gaps((1.0, 3.0), (3.5, 4.0))
    found = [undefined_findings(scene, rays=1500, seed=seed) for seed in range(12)]
    for place, volume in ((0, 1.0), (1, 0.25)):
        sizes = np.array([findings[place].size for findings in found])
        errors = np.array([findings[place].size_error for findings in found])
        assert (abs(sizes - volume) < 5 * errors).all()
        assert 0.4 < sizes.std(ddof=1) / errors.mean() < 2.5


@pytest.mark.parametrize("thin", [0.05, 0.005])
def test_a_thin_shell_is_one_region(thin):
    """Each part of the shell sees only its neighbours."""
    low, high = (-3, -3, -3), (3, 3, 3)
    rest = co.Box(low, high) - co.Sphere(2 + thin) | co.Sphere(2)
    found = undefined_findings(co.Scene(rest, domain=co.Box(low, high)))
    volume = 4 / 3 * PI * ((2 + thin) ** 3 - 8)
    assert len(found) == 1
    assert abs(found[0].size - volume) < 5 * found[0].size_error


def test_bent_gaps_are_one_region():
    """A channel surrounds three sides of a block. Parts between its ends connect them around the corners."""
    block = co.Box((0, 0, 0), (4, 4, 1))
    channel = co.Box((1, 1, -1), (1.2, 3, 2)) | co.Box((1, 2.8, -1), (3, 3, 2)) | co.Box((2.8, 1, -1), (3, 3, 2))
    (found,) = undefined_findings(co.Scene(block - channel, domain=block))
    assert abs(found.size - (0.2 * 2 + 1.6 * 0.2 + 0.2 * 2)) < 5 * found.size_error


@pytest.mark.parametrize("thin", sampled([1e-4, 1e-3, 1e-2], 3))
def test_thin_gaps_are_one_region(thin):
    """The gap is a slab, or the space around a cone. Few rays see both sides of the cone's edges."""
    box = co.Box((0, 0, 0), (10, 10, 10))
    slab = co.Scene([co.Box((0, 0, 0), (10, 10, 5)), co.Box((0, 0, 5 + thin), (10, 10, 10))], domain=box)
    (found,) = undefined_findings(slab)
    assert abs(found.size - 100 * thin) < 5 * found.size_error
    turned = [body.rotate((1, 2, 3), 17) for body in slab.bodies]
    assert len(undefined_findings(co.Scene(turned, domain=box.rotate((1, 2, 3), 17)))) == 1
    shell = [box - co.Sphere(3 + thin, (5, 5, 5)), co.Sphere(3, (5, 5, 5))]
    assert len(undefined_findings(co.Scene(shell, domain=box))) == 1
    hole = co.Cone((5, 5, 1 - thin), (5, 5, 9 + thin), 3 + thin, 0.5 + thin)
    assert len(undefined_findings(co.Scene([box - hole, co.Cone((5, 5, 1), (5, 5, 9), 3, 0.5)], domain=box))) <= 2


def test_a_region_without_a_point_has_a_limit_and_no_volume():
    """None of n points in a box was in the region: at 95 % its volume is below 3 / n of the box, but need not be 0."""
    thin, turn = 1e-6, lambda shape: shape.rotate((1, 2, 3), 17)
    boxes = co.Box((0, 0, 0), (10, 10, 5)), co.Box((0, 0, 5 + thin), (10, 10, 10))
    (found,) = undefined_findings(co.Scene([turn(box) for box in boxes], domain=turn(co.Box((0, 0, 0), (10, 10, 10)))))
    assert found.size == 0
    assert 100 * thin < 3 * found.size_error
    assert f"a volume of less than about {3 * found.size_error:.1g}; seen by" in found.message


def test_regions_that_touch_in_an_edge_are_apart():
    box = co.Box((0, 0, 0), (2, 2, 1))
    scene = co.Scene([co.Box((0, 0, 0), (1, 1, 1)), co.Box((1, 1, 0), (2, 2, 1))], domain=box)
    found = undefined_findings(scene)
    assert len(found) == 2
    assert all(abs(finding.size - 1) < 5 * finding.size_error for finding in found)


def test_findings_of_other_kinds_have_no_standard_error():
    found = co.check(co.Scene([co.Sphere(), co.Sphere(1, (0.5, 0, 0))]), rays=3000)
    assert [finding.size_error for finding in found] == [0.0] * len(found) != []


def test_points_belong_to_the_nearest_of_few_places() -> None:
    """Two regions may have one place each, which is fewer than are looked at."""
    regions = UndefinedRegions([[], []], np.array([(0.0, 0, 0), (1.0, 0, 0)]), np.array([0, 1]))
    points = np.array([(0.2, 0, 0), (0.9, 0, 0)])
    for sees, expected in ((True, [0, 1]), (False, [0, 1])):
        found = regions.of_points(points, [0, 1], lambda one, _, sees=sees: np.full(len(one), sees))
        assert found.tolist() == expected
