"""Cards, shortcuts, mistakes with their lines, materials, importances, and how the importer recognizes a deck."""

import re
from fractions import Fraction

import numpy as np
import pytest

import conicoid as co
from conicoid.io.importers import is_mcnp
from conicoid.io.mcnp.cards import Card, DataCards, expand_entries, parse_deck

from .models import load_deck, names_at

PIN = """\
A pin
1 1 -10.4 -1 imp:n=1
2 2 0.05   1 -2 imp:n=1
3 1 -10    2 -3 imp:n=1
9 0 3 imp:n=0

1 cz 0.4
*2 cz 0.5
3 rpp -1 1 -1 1 -5 5

m1 92235.80c 0.05 92238.80c 0.95 8016 2 nlib=80c
m2 40000 -1
"""


def test_cards_are_joined_and_comments_dropped() -> None:
    text = "MESSAGE: outp=a\n runtpe=b\n\nThe Title\nc comment\n  C another\n1 0 -1 &\n2 $ note & more\n      IMP:N=1\nc\n\t\t3\n2 0 1\n\n1 SO 1\n\nMODE n\n\nwhatever"
    deck, problems = parse_deck(text.split("\n"))
    assert problems == []
    assert deck.title == "The Title"
    assert [(card.line, card.text.split()) for card in deck.cells] == [
        (7, ["1", "0", "-1", "2", "imp:n", "1", "3"]), (12, ["2", "0", "1"]),
    ]  # fmt: skip
    assert [card.text for card in deck.surfaces] == ["1 so 1"]
    assert [card.text for card in deck.data] == ["mode n"]


def test_shortcuts_and_numbers() -> None:
    found = expand_entries("1 2r 4 1i 8 2m j 2j 1.5-3 1d1 .5e+1".split())
    half = Fraction(3, 2000)
    assert found == [1, 1, 1, 4, 6, 8, 16, None, None, None, half, 10, 5]
    for wrong in ("r", "2i 3", "1 2i", "1 2i r", "1e999", "x", "1 999999999r", "j 2m", "1..2", "nan"):
        with pytest.raises(ValueError, match=r"shortcut|no number|beyond|more than|after|follow"):
            expand_entries(wrong.split())


def test_materials_importances_and_notes(tmp_path) -> None:
    scene = load_deck(tmp_path, PIN)
    assert [(b.name, b.material.name) for b in scene.bodies] == [
        ("cell 1", "m1 at 10.4 g/cm3"), ("cell 2", "m2"), ("cell 3", "m1 at 10 g/cm3"),
    ]  # fmt: skip
    fuel, cladding, _ = (b.material.properties for b in scene.bodies)
    assert (fuel["id"], fuel["density"], fuel["ao"]) == (1, 10.4, {"92235.80c": 0.05, "92238.80c": 0.95, "8016": 2.0})
    assert (cladding["atom_density"], cladding["wo"]) == (0.05, {"40000": 1.0})
    assert "importance 0, outside: cell 9" in scene.notes
    assert "boundary reflective: surface 2" in scene.notes
    assert "title: A pin" in scene.notes
    assert not co.check(scene)


def test_a_gap_is_found(tmp_path) -> None:
    """Cells must fill the outside of the cells of importance 0."""
    text = PIN.replace("2 2 0.05   1 -2 imp:n=1\n", "")
    assert [finding.kind for finding in co.check(load_deck(tmp_path, text), rays=20_000)] == ["undefined"]


def test_importances_in_the_data_block(tmp_path) -> None:
    text = PIN.replace(" imp:n=1", "").replace(" imp:n=0", "") + "imp:n 1 2r 0\n"
    assert [body.name for body in load_deck(tmp_path, text).bodies] == ["cell 1", "cell 2", "cell 3"]
    both = PIN.replace("imp:n=0", "imp:n=0 imp:p=1")
    assert len(load_deck(tmp_path, both).bodies) == 4


def test_options(tmp_path) -> None:
    text = PIN.replace("2 2 0.05 ", "2 0 ")
    assert len(load_deck(tmp_path, text).bodies) == 3
    assert len(load_deck(tmp_path, text, void=False).bodies) == 2
    assert [body.name for body in load_deck(tmp_path, text, only="cell 3").bodies] == ["cell 3"]
    with pytest.raises(ValueError, match="depth means nothing for an MCNP deck"):
        load_deck(tmp_path, text, depth=1)
    with pytest.raises(ValueError, match="max_bodies"):
        load_deck(tmp_path, text, max_bodies=2)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("1 1 -10.4 -1", "1 1 -10.4 -7", ":2:1: cell 1: region: refers to unknown surface 7"),
        ("1 1 -10.4 -1", "1 1 -10.4 (-1", r":2:1: cell 1: region: a '\)' is missing"),
        ("1 1 -10.4 -1", "1 1 -10.4 -1)", r":2:1: cell 1: region: a '\)' without"),
        ("1 1 -10.4 -1", "1 1 -10.4 #8", ":2:1: cell 1: region: '#8' refers to an unknown cell"),
        ("1 1 -10.4 -1", "1 1 -10.4 #1", ":2:1: cell 1: region: refers to itself"),
        ("1 1 -10.4 -1", "1 1 0 -1", ":2:1: cell 1: the density must not be 0"),
        ("1 1 -10.4 -1", "1 1 -10.4 -1 fil=3", ":2:1: cell 1: 'fil' is nothing that a cell has.*fill"),
        ("1 1 -10.4 -1", "1 1 -10.4 -1 fill=3", ":2:1: cell 1: fill: no cells are in the universe 3"),
        ("1 1 -10.4 -1", "1 1 -10.4 -1 trcl=3", ":2:1: cell 1: the transformation tr3 is not in the data block"),
        ("1 1 -10.4 -1", "1 1 -10.4 -1 lat=1", ":2:1: cell 1: lat: the cell must be a parallelepiped"),
        ("1 1 -10.4 -1", "1 1 -10.4 -1 lat=3", ":2:1: cell 1: lat must be 1"),
        ("2 2 0.05   1 -2 imp:n=1", "2 like 7 but u=3", ":3:1: cell 2: like: cell 7 is not defined before"),
        ("2 2 0.05 ", "1 2 0.05 ", ":3:1: cell 1: its number is taken by the cell of line 2"),
        ("1 cz 0.4", "1 cz -0.4", ":7:1: surface 1: the radius must be > 0"),
        ("1 cz 0.4", "1 cy/z 0.4", ":7:1: surface 1: 'cy/z' is no kind of surface"),
        ("1 cz 0.4", "1 5 cz 0.4", ":7:1: surface 1: the transformation tr5 is not"),
        ("1 cz 0.4", "1 cz 0.4 3", ":7:1: surface 1: cz needs 1 number, got 2"),
        ("3 rpp -1 1 -1 1 -5 5", "3 rpp 1 -1 -1 1 -5 5", ":9:1: surface 3: rpp: the x of one end must be below"),
        ("3 rpp -1 1", "1 rpp -1 1", ":9:1: surface 1: its number is taken"),
        ("m2 40000 -1", "tr1 0 0 0 1 1 0 0 1 0 0 0 1", ":12:1: tr1: the matrix of a transformation must be a rotation"),
        ("m2 40000 -1", "tr1 0 0 0 1 1 0 0", ":12:1: tr1: the matrix of a transformation is given by 9, 6, 5, 3"),
        ("m2 40000 -1", "read file=/etc/passwd", ":12:1: read: file '/etc/passwd' is outside of the folder that may"),
        ("m2 40000 -1", "read file=../x", ":12:1: read: file '../x' is outside of the folder that may be read"),
        ("m2 40000 -1", "read decode=secret file=x", ":12:1: read: is encrypted, or not written as READ FILE=name"),
        ("m2 40000 -1", "read file=deck.mcnp", ":12:1: read: file 'deck.mcnp' refers to itself"),
        ("m2 40000 -1", "#   imp:n", ":12:1: #: begins a table in columns"),
    ],
)  # fmt: skip
def test_mistakes_have_their_lines(tmp_path, old: str, new: str, message: str) -> None:
    assert old in PIN
    with pytest.raises(ValueError, match=message):
        load_deck(tmp_path, PIN.replace(old, new, 1))


def test_a_continued_card_inserts_no_file(tmp_path) -> None:
    """After & the line belongs to the card, whatever its first word is, also beyond comments."""
    (tmp_path / "x.txt").write_text("imp:n=1\n")
    for between in ("", "c note\n", "     $ note\n"):
        (tmp_path / "deck.mcnp").write_text(
            f"title\n1 0 -1 &\n{between}read file=x.txt\n2 0 1\n\n1 so 1\n\nimp:n 1 0\n"
        )
        with pytest.raises(ValueError, match="cell 1: 'read' is nothing that a cell has"):
            co.load(tmp_path / "deck.mcnp")


def test_files_that_a_deck_reads(tmp_path) -> None:
    """READ inserts a file after the card, also within an inserted file, and in any block (the manual, on READ)."""
    lines = PIN.splitlines()
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "Cells.inp").write_text("\n".join(lines[2:4]) + "\nREAD FILE = ../surfaces.inp noecho\n")
    (tmp_path / "surfaces.inp").write_text("\n".join(lines[4:8]) + "\n")
    deck = "\n".join(
        [*lines[:2], " read file=parts/Cells.inp $ cells", "read noecho", *lines[8:], "", "read file=none"]
    )
    assert load_deck(tmp_path, deck).bodies == load_deck(tmp_path, PIN).bodies
    # A file beside the deck goes before one beside the file that names it: MCNP runs in the folder of the deck
    (tmp_path / "parts" / "Cells.inp").write_text("\n".join(lines[2:4]) + "\nREAD FILE=parts/surfaces.inp\n")
    (tmp_path / "parts" / "surfaces.inp").write_text("\n".join(lines[4:8]) + "\n")
    assert load_deck(tmp_path, deck).bodies == load_deck(tmp_path, PIN).bodies
    (tmp_path / "parts" / "Cells.inp").write_text("\n".join(lines[2:4]) + "\nREAD FILE=surfaces.inp\n")
    (tmp_path / "parts" / "surfaces.inp").write_text("nonsense\n")
    assert load_deck(tmp_path, deck).bodies == load_deck(tmp_path, PIN).bodies
    (tmp_path / "surfaces.inp").write_text("\n".join(lines[4:8]).replace("cz 0.5", "cz -0.5"))
    with pytest.raises(ValueError, match=r":3:1: surface 2: the radius must be > 0, got -0.5 \(line 4 of surfaces.inp"):
        load_deck(tmp_path, deck)
    (tmp_path / "parts" / "deck.mcnp").write_text(deck.replace("parts/Cells.inp", "../above.inp"))
    (tmp_path / "above.inp").write_text("\n".join(lines[2:8]))
    path = tmp_path / "parts" / "deck.mcnp"
    with pytest.raises(ValueError, match=r"read: file '../above.inp' is outside of the folder"):
        co.load(path)
    assert co.load(path, root=tmp_path).bodies == load_deck(tmp_path, PIN).bodies
    with pytest.raises(ValueError, match="root must be a folder"):
        co.load(path, root=tmp_path / "none")


COMPLEMENTS = "".join(f"{n} 0 #{n - 1} #{n - 1} -1 imp:n=1\n" for n in range(2, 60))


@pytest.mark.parametrize(("deck", "message"), [
    ("t\n1 0 -1 fill=2\n2 0 -1 u=2 fill=3\n3 0 -1 u=3 fill=2\n\n1 so 1\n", "contain themselves: universe 2 → universe 3 → universe 2"),
    (f"t\n1 0 -1\n{COMPLEMENTS}\n1 so 1\n", "too many half-spaces|nests deeper"),
], ids=["universes in circles", "complements of complements"])  # fmt: skip
def test_cyclic_and_exploding_decks_are_refused(tmp_path, deck: str, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        load_deck(tmp_path, deck)


def test_a_transformation_of_the_filling_takes_the_place_of_trcl(tmp_path) -> None:
    """The filling of a cell moves with the cell only where FILL has no transformation (the manual, on FILL)."""
    text = "t\n1 0 -1 u=1\n2 0 -2 fill=1{} trcl=(2 0 0)\n\n1 so 1\n2 so 9\n"
    assert names_at(load_deck(tmp_path, text.format("")), [(2, 0, 0), (0, 1.5, 0)]) == ["cell 1 @ cell 2", None]
    moved = load_deck(tmp_path, text.format("(0 2 0)"))
    assert names_at(moved, [(2, 0, 0), (0, 1.5, 0)]) == [None, "cell 1 @ cell 2"]


def test_transformations_of_fillings_in_a_lattice_with_trcl(tmp_path) -> None:
    """A universe with a transformation does not inherit that of the cell (the manual, on FILL): only the planes do."""
    text = "t\n1 0 -1 u=1\n4 0 1 u=1\n2 0 -2 3 u=2 lat=1 fill=0:1 0:0 0:0 1{} 1 trcl=(2 0 0 0 1 0 -1 0 0 0 0 1)\n"
    text += "3 0 -4 fill=2\n9 0 4 imp:n=0\n\n1 s 0.5 0 0 0.4\n2 px 1\n3 px 0\n4 rpp 1 4 -3 3 -3 3\n"
    balls = [(2, 0.5, 0), (2, 1.5, 0)]
    same = "cell 1 @ cell 3, cell 2, lattice [0, 0, 0]", "cell 1 @ cell 3, cell 2, lattice [1, 0, 0]"
    assert names_at(load_deck(tmp_path, text.format("")), balls) == [*same]
    moved = load_deck(tmp_path, text.format("(3 0.5 0)"))
    assert names_at(moved, [(3.5, 0.5, 0), *balls]) == [same[0], same[0].replace("cell 1", "cell 4"), same[1]]


def test_a_lattice_beside_other_cells_of_its_universe(tmp_path) -> None:
    text = "t\n1 0 -1 u=1\n2 0 -2 u=2 lat=1 fill=0:1 0:0 0:0 1 1\n5 0 2 u=2\n3 0 -4 fill=2\n9 0 4 imp:n=0\n\n"
    text += "1 so 99\n2 rpp 0 1 0 1 0 0\n4 rpp -3 3 -3 3 -3 3\n"
    scene = load_deck(tmp_path, text)
    assert any("line 3: lattice of cell 2: other cells are in its universe" in note for note in scene.notes)
    inside = "cell 1 @ cell 3, cell 2, lattice [{}, 0, 0]"
    assert names_at(scene, [(0.5, 0.5, 0), (1.5, 0.5, 2), (-1, 0, 0)]) == [
        inside.format(0), inside.format(1), "cell 5 @ cell 3",
    ]  # fmt: skip
    first, second = text.index("2 0 -2"), text.index("5 0 2")
    swapped = text[:first] + "5 0 2 u=2\n" + text[first:second] + text[second + 10 :]
    assert names_at(load_deck(tmp_path, swapped), [(1.5, 0.5, 2), (0.5, 0.5, 0)]) == [
        "cell 5 @ cell 3",
        inside.format(0),
    ]


def test_shortcuts_in_a_filling(tmp_path) -> None:
    text = "t\n1 0 -1 u=1\n4 0 -1 u=3\n2 0 -2 u=2 lat=1 fill=0:4 0:0 0:0 {}\n3 0 -4 fill=2\n9 0 4 imp:n=0\n\n"
    text += "1 so 99\n2 rpp 0 1 0 1 0 0\n4 rpp -9 9 -9 9 -9 9\n"
    written = load_deck(tmp_path, text.format("1 1 0 0 3")).bodies
    assert load_deck(tmp_path, text.format("1 r 2j 3")).bodies == written
    assert load_deck(tmp_path, text.format("1 1r j j 3")).bodies == written
    empty = load_deck(tmp_path, text.format("5j"))
    assert len(empty) == 0
    assert any("lattice of cell 2: the cell around it may reach beyond it" in note for note in empty.notes)


MANUAL = """\
Repeated structures, an example of the manual
1 0 {} fill=1
2 0 {} u=1 fill=2 lat=1
3 0 -11 u=-2
4 0 11 u=2

1 px 0
2 px 50
3 py 10
4 py -10
5 pz 5
6 pz -5
7 px 10
8 py 0
20 rpp 0 50 -10 10 -5 5
30 rpp 0 10 0 10 0 0
11 s 5 5 0 4
"""


def test_boxes_that_are_infinite_in_a_direction(tmp_path) -> None:
    """Equal ends leave a direction out. The numbers of the facets after it are lower by two (the manual, on facets)."""
    planes, box = load_deck(tmp_path, MANUAL.format("1 -2 -3 4 -5 6", "-7 1 -3 8")), load_deck(
        tmp_path, MANUAL.format("-20", "-30")
    )  # fmt: skip
    points = np.random.default_rng(1).uniform((-5, -15, -9), (55, 15, 9), (2000, 3))
    assert names_at(planes, points) == names_at(box, points)
    text = "t\n1 0 -1 \n2 0 1 -1.3 -2\n\n1 rpp -1 1 3 3 -2 2\n2 rpp -5 5 -5 5 -5 5\n"
    scene = load_deck(tmp_path, text)
    assert names_at(scene, [(0, 9, 0), (3, 0, 1), (3, 0, 3)]) == ["cell 1", "cell 2", None]
    with pytest.raises(ValueError, match="surface 1 has facets 1 to 4, got 1.5"):
        load_deck(tmp_path, text.replace("-1.3", "-1.5"))
    with pytest.raises(ValueError, match="rpp: at most one direction may be infinite"):
        load_deck(tmp_path, text.replace("-1 1 3 3", "1 1 3 3"))


def test_hexagonal_prisms_of_a_million_centimetres_have_no_ends(tmp_path) -> None:
    text = "t\n1 0 -1 -2{}\n\n1 rhp 0 0 0 0 0 {} 1 0 0\n2 so 1e7\n"
    assert names_at(load_deck(tmp_path, text.format("", 999_999)), [(0, 0, 5), (0, 0, -5)]) == ["cell 1", None]
    assert names_at(load_deck(tmp_path, text.format("", "1e6")), [(0, 0, 5), (0, 0, -5), (2, 0, 0)]) == [
        "cell 1", "cell 1", None,
    ]  # fmt: skip
    with pytest.raises(ValueError, match="surface 1 has facets 1 to 6, got 1.7"):
        load_deck(tmp_path, text.format(" -1.7", "1e6"))


def test_a_continued_line_that_lacks_a_blank(tmp_path) -> None:
    hint = "a continued line needs five blanks, this one has 4"
    for first, second in (("-1", "-2 imp:n=1"), ("(-1", "-2) imp:n=1"), ("-1", "2 1 -1 imp:n=1"), ("-1", "#2 imp:n=1")):
        text = PIN.replace("1 1 -10.4 -1 imp:n=1", f"1 1 -10.4 {first}\n    {second}")
        with pytest.raises(ValueError, match=f":[34]:1: .*; {hint}"):
            load_deck(tmp_path, text)
    # All cards are indented, and the blanks do not explain the mistake
    indented = "t\n   1 0 -1\n  10 0 -9\n   2 0 1\n\n  1 so 1\n  2 px 0\n"
    with pytest.raises(ValueError, match=r"\A\S*:3:1: cell 10: region: refers to unknown surface 9\Z"):
        load_deck(tmp_path, indented)
    # Without these numbers a card of the geometry has another meaning: a rotation, universes
    head = "t\n1 0 -1\n\n1 5 rpp 0 3 0 5 0 7\n\n"
    for card in ("tr5 10 0 0\n{}0 1 0 -1 0 0 0 0 1", "*tr5 10 0 0\n{}90 0 90 180 90 90 90 90 0", "tr5 9\nimp:n\n{}1"):
        with pytest.raises(ValueError, match=f":[78]:1: .*; {hint}"):
            load_deck(tmp_path, head + card.format("    "))
        with pytest.raises(
            ValueError, match=r":[78]:1: \d+: must begin with the name of a card; numbers of \S+ are not"
        ):
            load_deck(tmp_path, head + card.format(""))
    notes = load_deck(tmp_path, PIN.replace("92235.80c 0.05", "92235.80c 0.05\n   ")).notes
    assert any(f"line 12: '92238.80c' is not read; {hint}" in note for note in notes)


def test_no_elements_beyond_the_cell_around_a_turned_lattice(tmp_path) -> None:
    """A box of half side 1.4 reaches 1.4 (0.6 + 0.8) = 1.96 along the lattice's axes; elements 3 begin at 2.5."""
    text = "t\n1 0 -1 fill=1 (0 0 0 0.6 0.8 0 -0.8 0.6 0 0 0 1)\n2 0 -2 lat=1 u=1 fill=2\n3 1 -1 -3 u=2\n4 0 3 u=2\n\n"
    surfaces = "1 rpp -1.4 1.4 -1.4 1.4 -1.4 1.4\n2 rpp -0.5 0.5 -0.5 0.5 -0.5 0.5\n3 so 0.3\n\nm1 1001 1\n"
    scene = load_deck(tmp_path, text + surfaces)
    found = [re.search(r"lattice \[(.+), (.+), (.+)\]", body.name) for body in scene.bodies]
    steps = np.array([tuple(map(int, each.groups())) for each in found if each is not None])
    assert len(steps) == len(scene.bodies) > 27
    assert np.abs(steps).max(axis=0).tolist() == [2, 2, 1]


def test_one_axis_is_enough_where_the_others_do_not_matter(tmp_path) -> None:
    text = "t\n1 0 -1\n\n1 1 rcc 0 0 0 3 0 0 1\n\ntr1 0 0 0 0 1 0\n"
    scene = load_deck(tmp_path, text)
    assert names_at(scene, [(0, 2.5, 0.9), (2.5, 0, 0)]) == ["cell 1", None]
    assert any("tr1: gives one axis" in note for note in scene.notes)


@pytest.mark.parametrize(("text", "suffix", "known"), [
    (PIN, "", True), (PIN, ".yaml", False), ("", ".inp", True), ("<geometry>\n1 0 -1\n</geometry>", ".i", False),
    ("3\nwater\nO 0 0 0\nH 1 0 0\nH 0 1 0\n", "", False), ("bodies:\n  - sphere:\n      radius: 1\n", "", False),
    ("message: x\n\ntitle\nc note\n 10 like 3 but u=2\n", "", True), ("title\nc note\nread file=cells.txt\n", "", True),
    ("title\nc note\n READ NOECHO FILE = cells.txt\n", "", True), ("title\nc note\nread file cells.txt\n", "", True),
    ("notes\nread files first\n", "", False),
])  # fmt: skip
def test_detection(text: str, suffix: str, known: bool) -> None:
    assert is_mcnp(text, suffix) == known


def test_a_deck_is_known_without_a_suffix(tmp_path) -> None:
    (tmp_path / "input").write_text(PIN, encoding="utf-8")
    assert len(co.load(tmp_path / "input").bodies) == 3


@pytest.mark.parametrize(
    ("old", "new", "remark"),
    [
        ("m2 40000 -1", "#    si1  sp1\n     1    0.5\n     2    0.5", "'#' is not read"),
        ("m2 40000 -1", "m2 40000 -1\ne0 1e-3 5ilog 10", None),
        ("-1 imp:n=1", "-1 ext:n=sx ext:p .7v2 imp:n=1", None),
        ("-1 imp:n=1", "-1 imp:n=1 ext:n x", None),
        ("m2 40000 -1", "m2 40000", "m2: its nuclides are not read: a fraction is missing after '40000'"),
        ("m2 40000 -1", "m2 1001 3i 5", "m2: its nuclides are not read"),
        ("m2 40000 -1", "m2 zr-90 -1", "m2: its nuclides are not read: 'zr-90' is no nuclide"),
    ],
)
def test_a_card_without_geometry_refuses_no_deck(tmp_path, old: str, new: str, remark: str | None) -> None:
    expected, scene = load_deck(tmp_path, PIN), load_deck(tmp_path, PIN.replace(old, new, 1))
    assert [body.shape for body in scene.bodies] == [body.shape for body in expected.bodies]
    assert remark is None or remark in " ".join(scene.notes)


def test_shortcuts_of_materials_and_of_logarithms(tmp_path) -> None:
    cards = DataCards()
    cards.read(Card(1, "m3 8016 8016"))
    assert cards.materials[3] == {"ao": {"8016": 8016}, "wo": {}}
    cards.read(Card(1, "m4 8016 r"))
    assert cards.materials[4] == cards.materials[3]
    assert expand_entries("-1 log -100".split()) == [-1, -10, -100]
    deck = "t\n1 0 -1\n2 0 1 -2\n3 0 2 -3\n4 0 3\n\n1 so 1\n2 so 2\n3 so 3\n\nimp:n 1 1ilog 4 0\n"
    assert len(load_deck(tmp_path, deck)) == 3
    with pytest.raises(ValueError, match="1ilog needs two numbers of one sign"):
        load_deck(tmp_path, deck.replace("1 1ilog 4 0", "0 1ilog 4 1"))


@pytest.mark.parametrize(("sign", "inside"), [("", -2), ("-", 2)])
def test_a_quadric_about_a_point_and_its_expansion_are_one(sign: str, inside: int, tmp_path) -> None:
    """0.1 (x - 0.7)² + 0.2 (y + 0.3)² + 0.3 (z - 0.9)² - 0.7 by hand: few of the decimals of its products are floats."""
    numbers = f"{sign}0.1 {sign}0.2 {sign}0.3 0 0 0 {sign}-0.14 {sign}0.12 {sign}-0.54 {sign}-0.39".replace("--", "")
    cells = f"1 0 -1\n2 0 {inside} 3\n3 0 1 -4"
    surfaces = f"1 sq 0.1 0.2 0.3 0 0 0 -0.7 0.7 -0.3 0.9\n2 gq {numbers}\n3 pz 0.8\n4 so 9"
    scene = load_deck(tmp_path, f"an ellipsoid\n{cells}\n\n{surfaces}\n\n")
    found = scene.crossings((0.5, -0.2, 5.0), (0.0, 0.0, -1.0))[0]
    plane, ball = 4.2, 10.0
    curved = (found.t != plane) & (found.t < ball)
    assert set(found.body[curved].tolist()) == {0, 1, 2}
    assert len(set(found.surface[curved].tolist())) == 1
