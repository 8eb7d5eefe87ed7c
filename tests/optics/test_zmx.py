"""Zemax files, read and imported."""

import math
import random
import re

import pytest

import conicoid as co

from ..command_line import run
from .matrices import first_order
from .zemax_text import file

# --- Zemax lens files: their values arrive, refusals name the line, and hostile files do no harm

BK7 = "X-BK7 0 0 1.5168 64.17 0 0 0 0 0 0"
SINGLET = [
    dict(curvature=1 / 50, thickness="6", glass=BK7, semi=10, more=["STOP"]),
    dict(curvature=-1 / 50, thickness="4.5E+1", semi=10),
]


def test_a_singlet(tmp_path):
    text = file(
        SINGLET, heights=(0, 3.5), waves=(0.4861327, 0.5875618, 0.6562725), primary=2, name="a singlet, f = 49.4"
    )
    expected = first_order([(50, 6, 1.5168), (-50, 45, 1)])
    for encoding in ("utf-16", "utf-8", "utf-8-sig", "latin-1"):
        path = tmp_path / f"{encoding}.zmx"
        path.write_bytes(text.encode(encoding))
        system = co.optics.load_zmx(path)
        assert co.optics.focal_length(system) == pytest.approx(expected["efl"], rel=2e-9)
        assert (system.aperture, system.fields, system.name) == (10, (0, 3.5), "a singlet, f = 49.4")
        assert system.wavelengths == (0.5875618, 0.4861327, 0.6562725)
        assert system.bodies[0].shape == co.Lens(50, -50, 6, 20)
        assert system.image == 51
        assert system.stop == 0
    n = system.media[1]
    assert n.index(0.4861327) - n.index(0.6562725) == pytest.approx(0.5168 / 64.17, rel=1e-9)
    assert "X-BK7 by its index 1.5168" in system.omissions[0]


def test_a_telescope_of_conics():
    """Handbook of Optics II, chapter 18, has the numbers of its Cassegrain."""
    c1, c2 = -2.187226596675415774e-2, -5.208333333333333565e-2
    mirror = "MIRROR 0 0 1.5 40 0 0 0 0 0 0"
    text = file(
        [
            dict(thickness="16"),
            dict(curvature=c1, thickness="-16", glass=mirror, conic=-1.0, semi=10, more=["STOP", "CLAP 2.5 10 0"]),
            dict(curvature=c2, thickness="24.0350", glass=mirror, conic=-3.236, semi=3.1),
        ],
        aperture="FNUM 4.0 0",
        kind=2,
        heights=(0, 1.4),
    )
    system = co.optics.read_zmx(text)
    expected = first_order([(1 / c1, -16, "mirror"), (1 / c2, 24.035, "mirror")])
    assert co.optics.focal_length(system) == pytest.approx(expected["efl"], rel=2e-9)
    assert system.aperture == pytest.approx(expected["efl"] / 4, rel=1e-12)
    assert system.fields[1] == pytest.approx(math.degrees(math.atan(1.4 / expected["efl"])), rel=1e-12)
    assert system.bodies[0].shape.hole == 5
    assert system.bodies[1].shape.conic_constant == -3.236
    assert co.optics.spot(system).rms < 1e-4


def test_the_aperture_of_a_stop_and_a_near_object():
    rows = [
        dict(curvature=1 / 50, thickness="6", glass=BK7, semi=10),
        dict(curvature=-1 / 50, thickness="10", semi=10),
        dict(thickness="70", semi=3, more=["STOP"]),
    ]
    system = co.optics.read_zmx(file(rows, aperture="FLOA"))
    (a, _), _ = _to(rows[:2], 10)
    assert system.aperture == pytest.approx(6 / a, rel=1e-9)
    assert [body.name for body in system.bodies] == ["lens 1", "stop"]
    near = file(rows, aperture="OBNA 0.02", kind=1, heights=(0, 2)).replace("DISZ INFINITY", "DISZ 120")
    found = co.optics.read_zmx(near)
    assert found.object_distance == 120
    assert found.fields == (0, 2)
    assert found.aperture == pytest.approx(2 * (120 + found.pupil) * math.tan(math.asin(0.02)), rel=1e-12)


def _to(rows, thickness):
    """Return the matrix from the first surface of the singlet to a plane behind it."""
    import numpy as np

    n = 1.5168
    first, second = (np.array([[1, 0], [-p, 1]]) for p in ((n - 1) / 50, (1 - n) / -50))
    return np.array([[1, thickness], [0, 1]]) @ second @ np.array([[1, 6 / n], [0, 1]]) @ first


W = 0.55
AGF = {  # formula: (coefficients, n at 0.55 μm by the formula as OpticStudio's manual prints it)
    1: ("2.27 -0.01 0.01 2e-4 -1e-5 1e-6", math.sqrt(2.27 - 0.01 * W**2 + 0.01 / W**2 + 2e-4 / W**4 - 1e-5 / W**6 + 1e-6 / W**8)),
    2: ("1.04 0.006 0.23 0.02 1.01 103.5", math.sqrt(1 + sum(k * W**2 / (W**2 - f) for k, f in ((1.04, 0.006), (0.23, 0.02), (1.01, 103.5))))),
    3: ("1.5 0.004 1e-4 -0.002 1e-4 1e-6", 1.5 + 0.004 / (W**2 - 0.028) + 1e-4 / (W**2 - 0.028) ** 2 - 0.002 * W**2 + 1e-4 * W**4 + 1e-6 * W**6),
    4: ("0.3 1.0 0.1 0.02 0.2", math.sqrt(1 + 0.3 + W**2 / (W**2 - 0.01) + 0.02 / (W**2 - 0.04))),
    5: ("1.5 0.01 0.003", 1.5 + 0.01 / W + 0.003 / W**3.5),
    6: ("0.5 0.01 0.4 0.02 0.3 0.03 0.9 99", math.sqrt(1 + sum(k * W**2 / (W**2 - f) for k, f in ((0.5, 0.01), (0.4, 0.02), (0.3, 0.03), (0.9, 99))))),
    7: ("2.2 0.01 0.02 0.003", math.sqrt(2.2 + 0.01 / (W**2 - 0.02) - 0.003 * W**2)),
    8: ("1.2 1.01 0.02 0.003", math.sqrt(1.2 + 1.01 * W**2 / (W**2 - 0.02) - 0.003 * W**2)),
    9: ("1.2 1.0 0.01 0.5 100", math.sqrt(1.2 + W**2 / (W**2 - 0.01) + 0.5 * W**2 / (W**2 - 100))),
    10: ("2.2 -0.01 0.01 2e-4 -1e-5 1e-6 1e-7 1e-8", math.sqrt(2.2 - 0.01 * W**2 + 0.01 / W**2 + 2e-4 / W**4 - 1e-5 / W**6 + 1e-6 / W**8 + 1e-7 / W**10 + 1e-8 / W**12)),
    11: ("0.5 0.01 0.4 0.02 0.3 0.03 0.1 0.04 0.9 99", math.sqrt(1 + sum(k * W**2 / (W**2 - f) for k, f in ((0.5, 0.01), (0.4, 0.02), (0.3, 0.03), (0.1, 0.04), (0.9, 99))))),
    12: ("2.2 -0.01 0.01 2e-4 -1e-5 1e-6 1e-3 1e-4", math.sqrt(2.2 - 0.01 * W**2 + 0.01 / W**2 + 2e-4 / W**4 - 1e-5 / W**6 + 1e-6 / W**8 + 1e-3 * W**4 + 1e-4 * W**6)),
    13: ("2.2 -0.01 1e-3 0.01 2e-4 -1e-5 1e-6 1e-7 1e-8", math.sqrt(2.2 - 0.01 * W**2 + 1e-3 * W**4 + 0.01 / W**2 + 2e-4 / W**4 - 1e-5 / W**6 + 1e-6 / W**8 + 1e-7 / W**10 + 1e-8 / W**12)),
}  # fmt: skip


def test_catalogues_of_glasses(tmp_path):
    lines = ["CC all formulas"]
    for number, (row, _) in AGF.items():
        # Some makers break the line of coefficients
        row = row if number % 2 else " \r\n".join(row.rsplit(" ", 2))
        lines += [f"NM G{number} {number}.0 517642.251 1.5 60.0 0 1", "GC a comment", f"CD {row}", "LD 0.3 2.5"]
    lines += ["NM G2 1 0 1.5 60 0", "CD 9 0 0 0 0 0"]  # the first entry of a name counts
    lines += ["NM POLE 4", "CD 0.3 1.0 0.1 0.02"]  # without its last number formula 4 ends in B / λ²
    (tmp_path / "all.agf").write_text("\r\n".join(lines), encoding="utf-16")
    glasses = co.optics.load_agf(tmp_path / "all.agf")
    assert list(glasses) == [*(f"G{number}" for number in AGF), "POLE"]
    assert glasses["POLE"](W) == pytest.approx(math.sqrt(1.3 + W**2 / (W**2 - 0.01) + 0.02 / W**2), rel=1e-14)
    for number, (_, index) in AGF.items():
        found = glasses[f"G{number}"]
        assert found(W) == pytest.approx(index, rel=1e-14), number
        assert (found.name, found.source, found.range) == (f"G{number}", "all.agf", (0.3, 2.5))
        with pytest.raises(ValueError, match=r"wavelength must be in \[0.3, 2.5\]"):
            found(3.0)
    # Every reader takes a lens file
    (tmp_path / "lens.zmx").write_text(file([SINGLET[0] | dict(glass="g8 0 0 1.5 40 0 0 0"), SINGLET[1]], waves=(W,)))
    lens = co.optics.load_zmx(tmp_path / "lens.zmx", glasses=tmp_path / "all.agf")
    assert lens.media[1].index(W) == pytest.approx(AGF[8][1], rel=1e-14)
    assert co.load(tmp_path / "lens.zmx", glasses=tmp_path / "all.agf").bodies == lens.bodies
    assert (
        run("import", tmp_path / "lens.zmx", "-o", tmp_path / "a.yaml", "--glasses", tmp_path / "all.agf").exit_code
        == 0
    )
    assert co.load(tmp_path / "a.yaml").bodies == lens.bodies
    info = run("info", tmp_path / "lens.zmx", "--glasses", tmp_path / "all.agf")
    assert re.search(r"lens 1 +g8", info.stdout), info.stderr
    refusal = run("info", tmp_path / "a.yaml", "--glasses", tmp_path / "all.agf")
    assert refusal.exit_code == 2
    assert "a.yaml: --glasses goes with a lens file; it would be ignored" in refusal.stderr


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("CC nothing", "holds no glass"),
        ("NM A 14 0 1 1\nCD 1", r":1:1: A: must have a formula from 1 to 13, got 14"),
        ("NM A 1 0 1 1\nCD 1 x", r":2:1: A: CD: must have a finite number at place 2, got 'x'"),
        ("NM A 1 0 1 1\nCD 1 1e999", r":2:1: A: CD: must have a finite number at place 2, got '1e999'"),
        ("NM A 1 0 1 1\nCD 1\n1_0", r":3:1: A: CD: must have a finite number at place 1, got '1_0'"),
        ("NM A 1 0 1 1\nCD \u0662", r":2:1: A: CD: must have a finite number at place 1"),
        ("NM A inf\nCD 1", r":1:1: NM: must have a finite number at place 2, got 'inf'"),
        ("NM A 1.9\nCD 1", r":1:1: NM: must have a whole number at place 2, got '1.9'"),
        ("NM A 1 0 1 1\nCD 1\nLD 1", r":3:1: A: LD: must have a finite number at place 2, got ''"),
        ("NM A 1 0 1 1\nCD 1" + "\n1" * 300_000, "has more than 200,000 lines"),  # each line copied all before it
        ("NM A 1 0 1 1\nCD " + "1 " * 300_000, r":2:1: is longer than 20,000 characters"),
        ("NM A 1 0 1 1\nCD 1\nLD 2 1", r":1:1: A: Schott: range must be two rising"),
        ("NM A\nCD 1", r":1:1: NM: must have a finite number at place 2, got ''"),
        ("NM A 2 0 1 1\nGC no CD", r":1:1: A: must have coefficients"),
    ],
)
def test_mistakes_of_catalogues(text, message, tmp_path):
    (tmp_path / "wrong.agf").write_text(text)
    with pytest.raises(co.SceneFileError, match=message):
        co.optics.load_agf(tmp_path / "wrong.agf")
    with pytest.raises(co.SceneFileError, match="is a catalogue of glasses, no scene: co.optics.load_agf reads it"):
        co.load(tmp_path / "wrong.agf")


@pytest.mark.parametrize("ends", ["0 0", "0.0 2.5", "0.4 0"])
def test_a_range_of_0_in_a_catalogue_is_none(ends, tmp_path):
    """One such glass must not make all others unreadable."""
    (tmp_path / "some.agf").write_text(f"NM A 1 0 1 1\nCD 1\nLD {ends}\nNM B 1 0 1 1\nCD 1\nLD 0.3 2.5\n")
    glasses = co.optics.load_agf(tmp_path / "some.agf")
    assert (glasses["A"].range, glasses["B"].range) == (None, (0.3, 2.5))


def test_a_glass_that_cannot_be_read_refuses_no_other(tmp_path):
    (tmp_path / "some.agf").write_text("NM A 14 0\nCD 1\nNM B 1 0\nCD 4\nNM A 1 0\nCD 1\nNM\nNM C 2\nCD 1 x\n")
    with pytest.warns(UserWarning, match=r"(?s)3 glasses left out:.*:1:1: A.*14.*:7:1: NM.*:9:1: C: CD.*'x'"):
        glasses = co.optics.load_agf(tmp_path / "some.agf")
    assert (list(glasses), glasses["B"](0.5)) == (["B"], 2)  # n² = 4 for all wavelengths


def test_all_missing_glasses_are_listed_at_once():
    rows = [SINGLET[0] | dict(glass=f"{name} 0 0 1.5 40 0 0 0") for name in ("SF99", "XK1")] + [SINGLET[1]]
    with pytest.raises(co.SceneFileError) as error:
        co.optics.read_zmx(file(rows))
    assert [problem.where for problem in error.value.problems] == ["surface 1: GLAS", "surface 2: GLAS"]
    assert all(name in str(error.value) for name in ("SF99", "XK1"))


@pytest.mark.parametrize(
    ("glasses", "index"),
    [({"SF99": 1.7}, 1.7), ({"SF99": (1.6, 40)}, 1.6), ({"SF99": lambda wave: 1.5 + wave / 10}, 1.55)],
)
def test_glasses_may_be_given(glasses, index):
    rows = [SINGLET[0] | dict(glass="SF99 0 0 1.5 40 0 0 0"), SINGLET[1]]
    text = file(rows, waves=(0.5,))
    with pytest.raises(
        co.SceneFileError,
        match=r"text:\d+:1: surface 1: GLAS: 'SF99' is not in the catalogue: glasses=\{'SF99': index\} gives",
    ):
        co.optics.read_zmx(text)
    system = co.optics.read_zmx(text, glasses=glasses)
    assert system.media[1].name == "SF99"
    expected = system.media[1].index(0.5)
    if index != 1.6:
        assert expected == pytest.approx(index, rel=1e-15)
    assert co.optics.focal_length(system) == pytest.approx(
        first_order([(50, 6, expected), (-50, 0, 1)])["efl"], rel=2e-9
    )


def test_a_glass_by_its_numbers_alone():
    rows = [SINGLET[0] | dict(glass="___BLANK 1 0 1.5 40 0 0 0"), SINGLET[1]]
    assert co.optics.read_zmx(file(rows)).media[1].index(0.5875618) == pytest.approx(1.5, rel=1e-15)


def test_an_asphere_without_terms_is_a_conic():
    rows = [SINGLET[0] | dict(kind="EVENASPH", conic=-0.5, more=["PARM 1 0", "PARM 2 0.0"]), SINGLET[1]]
    assert co.optics.read_zmx(file(rows)).bodies[0].shape.front_conic == -0.5


REFUSED = [
    (lambda: file([SINGLET[0] | dict(kind="EVENASPH", more=["PARM 2 1e-6"]), SINGLET[1]]), r"surface 1: TYPE: EVENASPH has the aspheric term PARM 2"),
    (lambda: file([SINGLET[0], dict(kind="COORDBRK"), SINGLET[1]]), r"surface 2: TYPE: COORDBRK tilts or shifts the axis, .*: remove it, or write the surfaces before and behind it as files"),
    (lambda: file(SINGLET).replace("MODE SEQ", "MODE NSC"), r"MODE: must be SEQ, a sequence of surfaces, got 'NSC'"),
    (lambda: file(SINGLET).replace("UNIT MM", "UNIT FURLONG"), r"UNIT: must be one of MM, CM, IN, METER, M, got 'FURLONG'"),
    (lambda: file(SINGLET).replace("CURV 0.02 ", "CURV nan "), r"surface 1: CURV: must have a finite number at place 1, got 'nan'"),
    (lambda: file(SINGLET).replace("CURV 0.02 ", "CURV 1_0 "), r"surface 1: CURV: must have a finite number at place 1, got '1_0'"),
    (lambda: file(SINGLET).replace("DISZ 6", "DISZ 1e999"), r"surface 1: DISZ: must have a finite number"),
    (lambda: file(SINGLET).replace("DISZ 6", "DISZ INFINITY"), r"surface 1: DISZ: must be finite, but for the object's"),
    (lambda: file(SINGLET).replace("DISZ 6", "DISZ"), r"surface 1: DISZ: must have a finite number at place 1, got ''"),
    (lambda: file(SINGLET).replace("SURF 2", "SURF 7"), r"SURF: must be number 2, as they are counted in order, got 7"),
    (lambda: file([]), r"must have at least 3 surfaces: .* got 2"),
    (lambda: "", r"must have at least 3 surfaces"),
    (lambda: file([SINGLET[0] | dict(semi=30), SINGLET[1] | dict(semi=30)]), r"text:20:1: surface 1 and surface 2: Lens: "),
    (lambda: file(SINGLET) + "x" * 30_000, r"is longer than 20,000 characters"),
    (lambda: "\n" * 300_000, r"has more than 200,000 lines"),
    (lambda: "x" * 9_000_000, r"is longer than 8,000,000 characters"),
    (lambda: file([dict(thickness="1")] * 1100), r"there are more than 1,000 surfaces"),
]  # fmt: skip


@pytest.mark.parametrize("case", range(len(REFUSED)))
def test_invalid_lens_files_are_refused(case):
    make, message = REFUSED[case]
    with pytest.raises(co.SceneFileError, match=message):
        co.optics.read_zmx(make())


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_files_are_known_by_their_first_surface(end, tmp_path):
    (tmp_path / "lens").write_bytes(file(SINGLET).replace("\n", end).encode("utf-16"))
    assert co.load(tmp_path / "lens").unit == "mm"


@pytest.mark.parametrize(("content", "error", "message"), [
    (None, FileNotFoundError, "none.zmx"), (b"SURF 0\0\0\0\0", co.SceneFileError, "is no text: it holds NUL characters"),
    (b"\n" * 8_000_001, co.SceneFileError, "is larger than 8,000,000 bytes"),
], ids=["missing", "binary", "large"])  # fmt: skip
def test_files_that_are_none(content, error, message, tmp_path):
    if content:
        (tmp_path / "none.zmx").write_bytes(content)
    with pytest.raises(error, match=message):
        co.optics.load_zmx(tmp_path / "none.zmx")


def mutated_text(text, rng):
    """Return a file with some of its words, lines and characters changed."""
    lines = text.splitlines()
    for _ in range(rng.randint(1, 4)):
        i = rng.randrange(len(lines))
        kind = rng.randrange(5)
        words = lines[i].split(" ")
        if kind == 0:
            words[rng.randrange(len(words))] = rng.choice(
                ["", "nan", "-1e99", "1e-99", "0", "INFINITY", "MIRROR", "é", "9" * 400, "1e9", "-3", "{}"]
            )
            lines[i] = " ".join(words)
        elif kind == 1:
            del lines[i]
        elif kind == 2:
            lines.insert(rng.randrange(len(lines)), lines[i])
        elif kind == 3:
            lines[i] = lines[i][: rng.randrange(len(lines[i]) + 1)]
        else:
            at = rng.randrange(len(lines[i]) + 1)
            lines[i] = lines[i][:at] + chr(rng.randrange(1, 0x2FF)) + lines[i][at:]
        if not lines:
            return ""
    return "\n".join(lines)


def broken(count, seed):
    """Check mutated files: each is read, or refused with a message of its own."""
    rng = random.Random(seed)
    mirror = "MIRROR 0 0 1.5 40 0"
    texts = [
        file(SINGLET, heights=(0, 5)),
        file([dict(thickness="16"), dict(curvature=-0.02, thickness="-16", glass=mirror, conic=-1.0, semi=10)]),
    ]
    read = 0
    for _ in range(count):
        text = mutated_text(rng.choice(texts), rng)
        try:
            system = co.optics.read_zmx(text)
        except co.SceneFileError as error:
            assert str(error).startswith("text")
            assert len(str(error)) < 1000
            continue
        read += 1
        assert all(math.isfinite(z) for z in (*system.vertices, system.image, system.aperture))
        system.scene.first_hit((0, 0, -1e3), (0, 0, 1))
    return read


def test_mutated_files_are_read_or_refused():
    assert 20 < broken(150, seed=1) < 140


@pytest.mark.deep
def test_two_thousand_mutated_files():
    assert broken(2000, seed=2) > 200


# --- `co.load` recognizes a Zemax lens file by its content, and returns the scene of its lenses


@pytest.mark.parametrize("name", ["lens.zmx", "lens.txt"])
@pytest.mark.parametrize("encoding", ["utf-16", "utf-8"])
def test_a_lens_file_is_a_scene(tmp_path, name, encoding):
    path = tmp_path / name
    path.write_bytes(file(SINGLET).encode(encoding))
    scene = co.load(path)
    assert scene.bodies == co.optics.load_zmx(path).bodies
    assert scene.notes[0] == "2 surfaces, 1 body"
    assert len(co.load(path, only="lens").bodies) == 1
    with pytest.raises(ValueError, match="load: depth means nothing for a Zemax lens file"):
        co.load(path, depth=2)


def test_omissions_are_refused_on_request(tmp_path):
    path = tmp_path / "lens.zmx"
    obscured = [SINGLET[0] | dict(more=["STOP", "OBSC 0 1 2"]), SINGLET[1]]
    path.write_text(file(obscured), encoding="utf-8")
    with pytest.raises(ValueError, match="strict is set"):
        co.load(path, strict=True)


def test_glasses_of_the_catalogue_are_known_by_name():
    """Schott's own n_d of N-BK7 is 1.51680. The index and Abbe number of a file are not needed then."""
    rows = [SINGLET[0] | dict(glass="N-BK7 0 0 1.5 40 0 0 0"), SINGLET[1]]
    system = co.optics.read_zmx(file(rows))
    assert system.media[1].index(0.5875618) == pytest.approx(1.51680, abs=5e-6)
    assert system.omissions == ()
    assert co.optics.prescription([(50, 6, "N-BK7"), (-50, None)], 10).media[1].index(0.4861327) == pytest.approx(
        1.52238, abs=5e-6
    )


# --- Every entry of a file is read or named


def _without_indents(text):
    return "\n".join(line.strip() for line in text.splitlines())


def test_lines_that_are_not_indented_belong_to_their_surface():
    """Copies from pages lose the blanks, which alone mark a surface's lines."""
    text = file(SINGLET, waves=(0.5876,)) + "TOL TOFF 0 0\nMNUM 1 1\nMOFF 0 1\nEFFL 3 1 0\n"
    plain = co.optics.read_zmx(_without_indents(text))
    assert plain == co.optics.read_zmx(text)
    assert plain.bodies[0].shape == co.Lens(50, -50, 6, 20)


def test_an_aperture_has_an_inner_and_an_outer_radius():
    """Files of a maker of parabolic mirrors have `CLAP 0 25.4 0`: no hole, and an edge at 25.4."""
    mirror = dict(curvature=-0.01, thickness="-40", glass="MIRROR 0 0 1.5 40 0 0 0", semi=30)
    for aperture, diameter, hole in (("0 25.4 0", 50.8, 0), ("2 25.4 0", 50.8, 4), ("0 35 0", 60, 0), ("0", 60, 0)):
        row = co.optics.read_zmx(file([mirror | dict(more=[f"CLAP {aperture}"])])).rows[0]
        assert (row.diameter, row.hole) == (diameter, hole)
    lens = [SINGLET[0] | dict(more=["STOP", "CLAP 0 8 0"]), SINGLET[1]]
    system = co.optics.read_zmx(file(lens, aperture="ENPD 18"))
    assert (system.rows[0].diameter, system.rows[1].diameter) == (16, 20)
    rays = co.Rays([(0, 7.9, -10), (0, 8.1, -10)], [(0, 0, 1)] * 2)
    assert co.optics.trace(system, rays).arrived.tolist() == [True, False]
    lens[0] = SINGLET[0] | dict(more=["STOP", "CLAP 3 8 0"])
    assert "inner radius of an aperture (CLAP)" in " ".join(co.optics.read_zmx(file(lens)).omissions)


def test_fields_beside_the_y_axis():
    text = file(SINGLET, heights=(0, 0, 4)).replace("XFLN 0 0 0 0", "XFLN 0 -5 3")
    system = co.optics.read_zmx(text)
    slope = math.hypot(*(math.tan(math.radians(angle)) for angle in (3, 4)))
    assert system.fields == pytest.approx((0, 5, math.degrees(math.atan(slope))), rel=1e-14)
    assert "XFLN" in " ".join(system.omissions)
    near = text.replace("DISZ INFINITY", "DISZ 100").replace("FTYP 0", "FTYP 1")
    assert co.optics.read_zmx(near).fields == (0, 5, 5)


@pytest.mark.parametrize(
    ("kind", "fields", "omission"),
    [(2, (0, 5), None), (3, (0, 5), "real heights"), (4, (0,), "type 4"), (1, (0,), "type 1"), (7, (0,), "type 7")],
)
def test_kinds_of_fields_of_far_objects(kind, fields, omission):
    """An image has the height f tan(angle), f = R / (n - 1) of a plano-convex lens.

    A theodolite's angles (4) are not heights.
    """
    height = 100 / 0.5 * math.tan(math.radians(5))
    lens = [
        dict(curvature=0.01, thickness="4", glass="X 1 0 1.5 0", semi=9, more=["STOP"]),
        dict(thickness="50", semi=9),
    ]
    system = co.optics.read_zmx(file(lens, kind=kind, heights=(0, height)))
    assert system.fields == pytest.approx(fields, rel=1e-12)
    notes = [note for note in system.omissions if "fields" in note]
    assert [omission in note for note in notes] == ([True] if omission else [])


def test_both_kinds_of_apertures_of_near_objects():
    """The values are a half angle in degrees, and the f-number of the rays behind, from matrices of the tests."""
    near = file(SINGLET, aperture="OBNA 2 1").replace("DISZ INFINITY", "DISZ 120")
    system = co.optics.read_zmx(near)
    assert system.aperture == pytest.approx(2 * 120 * math.tan(math.radians(2)), rel=1e-12)
    system = co.optics.read_zmx(near.replace("OBNA 2 1", "FNUM 4 1"))
    (_, _), (c, d) = _to(SINGLET, 0)
    assert system.aperture == pytest.approx(2 * 120 / (2 * 4 * abs(c * 120 + d)), rel=1e-12)
    far = file(SINGLET, aperture="OBNA 0.1 0")
    assert "OBNA" in " ".join(co.optics.read_zmx(far).omissions)
    far = file(SINGLET, aperture="FNUM 4 1")
    assert co.optics.read_zmx(far).aperture == co.optics.read_zmx(far.replace("FNUM 4 1", "FNUM 4 0")).aperture


@pytest.mark.parametrize(
    ("line", "note"),
    [
        ("VDXN 0 0.1", "VDXN"), ("VDYN 0 0.1", "VDYN"), ("VCXN 0.2", "VCXN"), ("VCYN 0 0 1e-3", "VCYN"),
        ("VANN 5", "VANN"), ("RAIM 0 2 1 1 0 1", "RAIM"), ("GFAC 1 0.5", "GFAC"), ("ENVD 60 1 1", "ENVD"),
        ("TELE 1", "TELE"), ("MNUM 3 1", "MNUM"), ("NEWK 1 2", "'NEWK' is not known"),
        ("FTYP 0 1 1 1 0 0 0", "telecentric aiming (FTYP)"), ("FTYP 0 0 1 1 0 0 0", None), ("VDXN 0 0", None), ("RAIM 0 0 1 1 0 1", None), ("GFAC 0 0", None), ("ENVD 60 1 0", None),
        ("ENVD 20 1 1", None), ("MNUM 1 1", None), ("NOTE 0 OAPM", None),
    ],
)  # fmt: skip
def test_a_line_of_the_system_that_changes_light_is_named(line, note):
    notes = [one for one in co.optics.read_zmx(line + "\n" + file(SINGLET)).omissions if "X-BK7" not in one]
    assert len(notes) == (note is not None)
    assert note is None or note in notes[0]


@pytest.mark.parametrize("line", ["SQAP 3 2 0", "OBDC 0 190", "SPID 1 2", "SCBD 1 0 0 0 0 90", "FILT 3"])
def test_a_line_of_a_surface_that_changes_light_is_named(line):
    system = co.optics.read_zmx(file([SINGLET[0] | dict(more=["STOP", line]), SINGLET[1]]))
    assert line.split()[0] in " ".join(system.omissions)


def test_an_extended_asphere_has_its_terms_beside():
    more = ["STOP", "XDAT 1 2 0 0", "XDAT 2 10 0 0", "XDAT 3 0.001 0 0"]
    rows = [SINGLET[0] | dict(kind="XASPHERE", more=more), SINGLET[1]]
    with pytest.raises(co.SceneFileError, match="surface 1: TYPE: XASPHERE has the aspheric term XDAT 3"):
        co.optics.read_zmx(file(rows))
    rows[0] = rows[0] | dict(more=[*more[:3], "XDAT 3 0 0 0"])
    assert co.optics.read_zmx(file(rows)).bodies[0].shape == co.Lens(50, -50, 6, 20)


def test_a_file_without_bodies_is_reported():
    assert "there are no bodies" in co.optics.read_zmx(file([dict(), dict()])).omissions[0]


@pytest.mark.parametrize(
    ("name", "index"),
    [("BK7", 1.51680), ("SK16", 1.62041), ("n-bk7", 1.51680), ("N-BK7HT", 1.51680), ("N-BK7HTi", 1.51680),
     ("SILICA", 1.45846), ("silica", 1.45846), ("CAF2", 1.43385), ("MGF2", 1.37774), ("caf2", 1.43385)],
)  # fmt: skip
def test_other_names_of_glasses(name, index):
    """n_d is from the makers' sheets, for fused silica and CaF2 from Malitson, for MgF2's ordinary ray from Dodge."""
    system = co.optics.read_zmx(file([SINGLET[0] | dict(glass=f"{name} 0 0 1.5 40 0 0 0"), SINGLET[1]]))
    assert system.media[1].index(0.5875618) == pytest.approx(index, abs=1e-5)
    assert f"{name} by the formula of" in system.omissions[0]
    model = co.optics.read_zmx(file([SINGLET[0] | dict(glass=f"{name} 1 0 1.7 40 0 0 0"), SINGLET[1]]))
    assert model.media[1].index(0.5875618) == pytest.approx(1.7, rel=1e-12)


@pytest.mark.parametrize(("word", "unit"), [("MM", "mm"), ("CM", "cm"), ("IN", "in"), ("METER", "m"), ("M", "m")])
def test_a_file_states_its_unit(tmp_path, word, unit):
    path = tmp_path / "lens.zmx"
    path.write_text(file(SINGLET).replace("UNIT MM", f"UNIT {word}"))
    assert co.optics.load_zmx(path).unit == co.optics.load_zmx(path).scene.unit == co.load(path).unit == unit
