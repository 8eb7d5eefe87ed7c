"""Slices and voxels in files, and the commands that write them."""

import importlib
import math
import re
import sys
import xml.etree.ElementTree as ElementTree
import zlib
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import conicoid as co

from ..command_line import execute, failure, run, scene_file

# --- Slices and voxels as files, against readers of the formats

SCENE = co.Scene([
    co.Body(co.Sphere(1), co.matte("#c03020", name="red <one>"), "ball & all"),
    co.Body(co.Box((0, -1.5, -1), (1.5, 1.5, 1)), co.matte("#3050c0", name="blue")),
    co.EllipticParaboloid(1, 1, (0, 2)).rotate((1, 0, 0), 90).translate((-2, 1, 0)),
    co.HyperbolicCylinder(4, 1, co.Box((-1, -1, -1), (1, 1, 1))).translate((-2, -1.5, 0)),
])  # fmt: skip
CUT = SCENE.slice(origin=(-3.5, -3, 0.125), u=(6, 0, 0), v=(0, 6, 0), pixels=300)
SVG = "{http://www.w3.org/2000/svg}"


def svg_of(tmp_path, **options):
    CUT.save(tmp_path / "cut.svg", **options)
    return ElementTree.parse(tmp_path / "cut.svg").getroot()


def places_of(text: str):
    """Return numbers of a path, which has letters between them."""
    return [float(number) for number in re.findall(r"-?\d[\d.e+-]*", text)]


def in_plane(x, y):
    """Return where in the world pixels of the slice are: 50 to a length, from the corner (-3.5, -3)."""
    return np.asarray(x) / 50 - 3.5, 3 - np.asarray(y) / 50


def test_svg_has_true_curves(tmp_path):
    root = svg_of(tmp_path)
    paths = [path.get("d") for path in root.iter(f"{SVG}path")]
    assert len(paths) == len([one for one in CUT.outlines if one.left[:1] != one.right[:1]])
    arcs = [path for path in paths if "A" in path]
    assert arcs
    assert any("Q" in path for path in paths)
    assert any("C" in path for path in paths)
    radius = math.sqrt(1 - 0.125**2)
    circles = [places_of(path) for path in arcs if abs(places_of(path)[2] - 50 * radius) < 1]
    for numbers in circles:
        assert numbers[2:4] == pytest.approx([50 * radius] * 2, rel=1e-14)
        for x, y in (numbers[:2], numbers[-2:]):
            a, b = in_plane(x, y)
            assert a * a + b * b == pytest.approx(radius**2, abs=1e-12)
    # the paraboloid y = 1 - ((x + 2)² + z²), turned: quadratic Béziers are parabolas, and this is that one
    for x0, y0, x1, y1, x2, y2 in (places_of(path) for path in paths if "Q" in path):
        t = np.linspace(0, 1, 9)
        x, y = ((1 - t) ** 2 * a + 2 * t * (1 - t) * b + t * t * c for a, b, c in ((x0, x1, x2), (y0, y1, y2)))
        a, b = in_plane(x, y)
        assert 1 - b == pytest.approx((a + 2) ** 2 + 0.125**2, abs=1e-12)


@pytest.mark.parametrize("name", ["a\0b", "a\x01b", "a\ud800b", "a\ufffeb", "a\x0bb"])
def test_names_with_characters_that_xml_has_not(name, tmp_path):
    """XML 1.0, production 2, allows no control characters but tab and ends of lines, no half pairs, not U+FFFE."""
    scene = co.Scene([co.Body(co.Sphere(1), co.matte("red", name=name), name=name)])
    scene.slice("z").save(tmp_path / "a.svg", by="material")
    explained = scene.explain((0, 0, 5), (0, 0, -1))
    explained.save(tmp_path / "a.html")
    for text in ((tmp_path / "a.svg").read_text("utf-8"), explained.figure().svg):
        ElementTree.fromstring(text)
    assert not any(ord(c) < 32 and c not in "\n\t" for c in (tmp_path / "a.html").read_text("utf-8"))
    scene.slice("z").save(tmp_path / "a.pdf")


def test_svg_has_a_legend_of_colours(tmp_path):
    assert [text.text for text in svg_of(tmp_path).iter(f"{SVG}text")] == ["ball & all", "body 1", "body 2", "body 3"]
    by_material = [text.text for text in svg_of(tmp_path, by="material").iter(f"{SVG}text")]
    assert by_material == ["red <one>", "blue", "no material"]
    plain = svg_of(tmp_path, legend=False, outlines=False)
    assert not list(plain.iter(f"{SVG}text"))
    assert not list(plain.iter(f"{SVG}path"))


def cubics_of(content: str):
    """Return (n, 4, 2), the Béziers of a page's content."""
    found, here = [], None
    for line in content.splitlines():
        numbers: list[float] = []
        for word in line.split():
            if re.fullmatch(r"-?[\d.]+", word):
                numbers.append(float(word))
                continue
            if word == "m":
                here = numbers[-2:]
            elif word == "c":
                found.append([here, numbers[-6:-4], numbers[-4:-2], numbers[-2:]])
                here = numbers[-2:]
            numbers = []
    return np.array(found)


def test_pdf_has_curves_within_its_bound(tmp_path):
    CUT.save(tmp_path / "cut.pdf")
    data = (tmp_path / "cut.pdf").read_bytes()
    assert data.startswith(b"%PDF-1.4")
    assert data.rstrip().endswith(b"%%EOF")
    start = int(data.split(b"startxref\n")[1].split()[0])
    assert data[start:].startswith(b"xref\n0 7\n")
    for number, line in enumerate(data[start:].splitlines()[3:9], 1):
        assert data[int(line.split()[0]) :].startswith(b"%d 0 obj" % number)
    streams = [zlib.decompress(part.split(b"\nendstream")[0]) for part in data.split(b">>\nstream\n")[1:]]
    content = streams[0].decode("cp1252")
    assert "(ball & all) Tj" in content
    assert len(streams[1]) == 300 * 300 * 3
    height = int(re.search(rb"MediaBox \[0 0 \d+ (\d+)\]", data)[1])
    cubics = cubics_of(content)
    t = np.linspace(0, 1, 33)[:, None]
    radius, near = math.sqrt(1 - 0.125**2), 0
    for a, b, c, d in cubics:
        places = (1 - t) ** 3 * a + 3 * t * (1 - t) ** 2 * b + 3 * t**2 * (1 - t) * c + t**3 * d
        x, y = in_plane(places[:, 0], height - places[:, 1])
        if abs(np.hypot(x[0], y[0]) - radius) < 1e-3 and abs(np.hypot(x[16], y[16]) - radius) < 1e-2:
            assert np.hypot(x, y) * 50 == pytest.approx(50 * radius, abs=2e-6)
            near += 1
    assert near >= 2


def test_pictures_have_outlines_and_a_legend(tmp_path):
    pixels = np.asarray(CUT.image(outlines=False, legend=False))
    assert pixels.shape == (300, 300, 3)
    assert len(np.unique(pixels.reshape(-1, 3), axis=0)) == 5  # four bodies and nothing
    assert (pixels[CUT.body < 0] == 255).all()
    lined = np.asarray(CUT.image(legend=False))
    changed = (lined != pixels).any(axis=2)
    assert 0 < changed.mean() < 0.2
    edge = np.diff(CUT.body, axis=1) != 0
    assert (changed[:, 1:] | changed[:, :-1])[edge].all()  # where bodies meet, there is a line
    assert np.asarray(CUT.image()).shape[1] > 300
    CUT.save(tmp_path / "cut.png", "material")
    assert (tmp_path / "cut.png").read_bytes().startswith(b"\x89PNG")
    with pytest.raises(ValueError, match=r"slices are saved as \.svg, \.pdf, \.png"):
        CUT.save(tmp_path / "cut.gif")
    with pytest.raises(ValueError, match="did you mean 'material'"):
        CUT.image("materials")


def test_materials_have_their_own_colours_where_these_differ():
    pixels = np.asarray(CUT.image("material", outlines=False, legend=False))
    assert pixels[CUT.material == 0][0].tolist() == [0xC0, 0x30, 0x20]
    same = co.Scene(
        [co.Body(co.Sphere(1), co.matte("red", name=name)).translate((x, 0, 0)) for name, x in (("a", 0), ("b", 3))]
    )
    twice = np.asarray(same.slice("z", pixels=40).image("material", outlines=False, legend=False))
    assert len(np.unique(twice.reshape(-1, 3), axis=0)) == 3


def test_problems_are_shown_on_request():
    scene = co.Scene(
        [co.Box((-1, -1, -1), (0.5, 1, 1)), co.Box((0, -1, -1), (1, 1, 0.5))], domain=co.Box((-2, -1, -1), (1, 1, 1))
    )
    cut = scene.slice(origin=(-2.5, -1.5, 0.25), u=(4, 0, 0), v=(0, 3, 0), pixels=(80, 60))
    assert cut.overlapping.sum() == 10 * 40
    assert cut.undefined.sum() == 20 * 40
    shown = np.asarray(cut.image(problems=True, outlines=False, legend=False)).reshape(-1, 3).tolist()
    assert shown.count([255, 0, 0]) == 10 * 40
    assert shown.count([255, 0, 255]) == 20 * 40


ONE = co.Box((0, 0, 0), (1, 1, 1))


def overlap_pixels(tmp_path, other, origin):
    """Return pixels of a window where two bodies hold the center, where they overlap, and whether the legend says so."""
    scene = co.Scene([ONE, other])
    cut = scene.slice(origin=origin, u=(2, 0, 0), v=(0, 1, 0), pixels=(25, 15))
    cut.save(tmp_path / "cut.svg", problems=True)
    overlaps = int((scene.bodies_at(cut._window.rows(0, 15)).counts > 1).sum())
    return overlaps, int(cut.overlapping.sum()), "overlapping" in (tmp_path / "cut.svg").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("other", "origin"),
    [
        (co.Box((1, 0, 0), (2, 1, 1)), (0, 0, 0.5)),  # the centres of the middle column lie in the common wall
        (co.Box((1, 0.5, 0), (2, 1.5, 1)), (0, 0, 0.5)),  # also at an edge
        (co.Box((0, 0, 1), (1, 1, 2)), (0, 0, 1)),  # the window lies in it
        (co.Sphere(0.5, (1.5, 0.5, 0.5)), (0, 0, 0.5)),  # one point is common
        (co.Sphere(0.5, (0.5, 0.5, 1.5)), (-0.5, 0, 1)),
    ],
)
def test_bodies_that_touch_do_not_overlap(tmp_path, other, origin):
    held, overlapping, named = overlap_pixels(tmp_path, other, origin)
    assert held > 0
    assert (overlapping, named) == (0, False)


@pytest.mark.parametrize(
    ("other", "origin"),
    [
        (co.Box((math.nextafter(1, 0), 0, 0), (2, 1, 1)), (0, 0, 0.5)),  # by the last digit
        (co.Box((0, 0, math.nextafter(1, 0)), (1, 1, 2)), (0, 0, 1)),
        (ONE, (0, 0, 1)),  # on one side of the window only
        (co.Box((-1, 0, 0.5), (1, 1, 2)), (0, 0, 1)),
        (co.Box((1, 0, 0), (2, 1, 1)) | co.Sphere(2.0**-30, (1, 0.5, 0.5)), (0, 0, 0.5)),
    ],
)
def test_thin_overlaps_are_marked(tmp_path, other, origin):
    held, overlapping, named = overlap_pixels(tmp_path, other, origin)
    assert held >= overlapping > 0
    assert named


IDS = SCENE.voxels(((-1, -1, -1), (1, 2, 3)), (4, 6, 8))
SHARES = SCENE.voxels(((-1, -1, -1), (1, 2, 3)), (4, 6, 8), fractions="material", samples=2)


def test_npz(tmp_path):
    for voxels, names in ((IDS, ("body", "material")), (SHARES, ("fractions", "bounds"))):
        voxels.save(tmp_path / "voxels.npz")
        read = np.load(tmp_path / "voxels.npz")
        assert all((read[name] == getattr(voxels, name)).all() for name in (*names, "low", "high"))
        assert tuple(read["names"]) == voxels.names
    with pytest.raises(ValueError, match=r"voxels are saved as \.npz, \.zarr, \.vti, \.nrrd"):
        IDS.save(tmp_path / "voxels.tif")


def test_vti(tmp_path):
    pytest.importorskip("pyevtk")
    SHARES.save(tmp_path / "voxels.vti")
    data = (tmp_path / "voxels.vti").read_bytes()
    head, _, rest = data.partition(b'<AppendedData encoding="raw">')
    root = ElementTree.fromstring(head + b"</VTKFile>")
    image = root.find("ImageData")
    assert [float(x) for x in image.get("Spacing").split()] == [0.5, 0.5, 0.5]
    assert [float(x) for x in image.get("Origin").split()] == [-1, -1, -1]
    assert [int(x) for x in image.get("WholeExtent").split()] == [0, 4, 0, 6, 0, 8]
    arrays = root.findall(".//CellData/DataArray")
    assert [array.get("Name") for array in arrays] == [
        "red__one_", "red__one__bound", "blue", "blue_bound", "no_material", "no_material_bound",
    ]  # fmt: skip
    raw = rest[rest.index(b"_") + 1 :]
    for array, expected in zip(arrays[::2], SHARES.fractions, strict=True):
        at = int(array.get("offset")) + 8
        values = np.frombuffer(raw[at : at + expected.nbytes], "<f8")
        assert (values.reshape(8, 6, 4) == expected.transpose(2, 1, 0)).all()  # x goes fastest


@pytest.mark.parametrize(("voxels", "array"), [(IDS, IDS.body), (SHARES, SHARES.fractions)])
def test_nrrd(tmp_path, voxels, array):
    nrrd = pytest.importorskip("nrrd")
    voxels.save(tmp_path / "voxels.nrrd")
    values, header = nrrd.read(str(tmp_path / "voxels.nrrd"))
    assert (values == array).all()
    assert header["space origin"].tolist() == [-0.75, -0.75, -0.75]
    assert header["space directions"][-3:].tolist() == [[0.5, 0, 0], [0, 0.5, 0], [0, 0, 0.5]]


def test_zarr(tmp_path):
    zarr = pytest.importorskip("zarr")
    SHARES.save(tmp_path / "voxels.zarr")
    group = zarr.open_group(str(tmp_path / "voxels.zarr"), mode="r")
    assert (group["fractions"][...] == SHARES.fractions).all()
    assert (group["bounds"][...] == SHARES.bounds).all()
    assert tuple(group.attrs["names"]) == SHARES.names
    assert group.attrs["low"] == [-1, -1, -1]
    with pytest.raises(FileExistsError):
        SHARES.save(tmp_path / "voxels.zarr")


# --- conicoid slice, and the examples that draw slices

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
TEXT = "{http://www.w3.org/2000/svg}text"


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    return scene_file(tmp_path)


def test_a_slice_as_svg(scene, tmp_path):
    result = execute("slice", scene, "-o", tmp_path / "cut.svg", "--at", 0.5, "--pixels", 200)
    assert "cut.svg: 200 x " in result.output
    root = ElementTree.parse(tmp_path / "cut.svg").getroot()
    assert [text.text for text in root.iter(TEXT)] == ["ball", "body 1"]
    assert run("slice", scene, "-o", tmp_path / "cut.pdf", "--by", "material").exit_code == 0
    assert (tmp_path / "cut.pdf").read_bytes().startswith(b"%PDF")


def test_an_oblique_slice_as_a_picture(scene, tmp_path):
    plain = tmp_path / "plain.png"
    execute(
        "slice",
        scene,
        "-o",
        plain,
        "--origin",
        "-2,-2,-2",
        "--u",
        "4,0,4",
        "--v",
        "0,4,0",
        "--pixels",
        141,
        "--no-legend",
        "--no-outlines",
    )
    pixels = np.asarray(Image.open(plain))
    assert pixels.shape == (100, 141, 3)
    # the ball is a circle of radius 1 of a window that is 5.66 x 4
    counts = np.unique(pixels.reshape(-1, 3), axis=0, return_counts=True)[1]
    assert np.pi / (4 * np.sqrt(32)) == pytest.approx(min(counts, key=lambda n: abs(n - 1957)) / 14100, abs=0.01)


def test_invalid_options_are_refused(scene, tmp_path):
    out = tmp_path / "cut.svg"
    for arguments, message in (
        (("--by", "colour"), "--by must be one of body, material"),
        (("--axis", "w"), "--axis must be one of x, y, z"),
        (("--origin", "0,0,0"), "--origin goes with both --u and --v"),
        (("--origin", "0,0", "--u", "1,0,0", "--v", "0,1,0"), "--origin must be three numbers"),
        (("--u", "1,0,0"), "--u"),
        (("--origin", "0,0,0", "--u", "1,0,0", "--v", "0,1,0", "--axis", "x"), "--axis"),
    ):
        assert message in failure("slice", scene, "-o", out, *arguments)
    assert "slices are saved as .svg, .pdf, .png" in failure("slice", scene, "-o", tmp_path / "cut.gif")
    assert not out.exists()


def test_examples(monkeypatch, tmp_path):
    monkeypatch.syspath_prepend(str(EXAMPLES))
    valve = importlib.import_module("valve_slice").cut(80)
    assert {one.kind for one in valve.outlines} == {"line", "ellipse", "hyperbola"}  # oblique, so none is a parabola
    assembly = importlib.import_module("assembly_slice").cut(120)
    assert {"water", "uranium dioxide", "steel"} <= {material.name for material in assembly.materials}
    assert not assembly.overlapping.any()
    assert all(one.left or one.right for one in assembly.outlines)
    assembly.save(tmp_path / "assembly.svg", "material")
    for name in ("valve_slice", "assembly_slice"):
        del sys.modules[name]
