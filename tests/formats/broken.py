"""Scene files with mistakes: name -> (content, line, phrases that the message must hold).

Line 0 stands for the file as a whole. Contents are bytes where they are no text.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Broken:
    name: str
    content: bytes
    line: int
    phrases: tuple[str, ...]


CASES: list[Broken] = []


def broken(name: str, content: str | bytes, line: int, *phrases: str) -> None:
    data = content.encode() if isinstance(content, str) else content
    CASES.append(Broken(name, data, line, phrases))


def sphere(fields: str) -> str:
    """A scene with one sphere, in line 2."""
    return f"bodies:\n  - shape: {{Sphere: {fields}}}\n"


def body(text: str) -> str:
    return f"bodies:\n  - {text}\n"


# No text, no YAML -----------------------------------------------------------------------------------
broken("empty", "", 0, "is empty")
broken("only spaces", "  \n\n", 0, "is empty")
broken("only comments", "# nothing\n# here\n", 0, "is empty")
broken("null", "~\n", 0, "is empty")
broken("only a document marker", "---\n", 0, "is empty")
broken("binary", b"\x89PNG\r\n\x1a\n\x00\x00\x00\rIHDR\x00\x00", 1, "binary", "0x89")
broken("zero byte", b"bodies:\n  - \x00\n", 2, "binary", "zero byte")
broken("latin 1", "bodies:\n  - name: b\xe4r\n".encode("latin-1"), 2, "UTF-8", "0xe4")
broken("utf-16", "bodies: []\n".encode("utf-16"), 0, "UTF-16", "UTF-8")
broken("half a character", b"bodies: []  # \xc3", 1, "UTF-8", "0xc3")
broken("control character", b"bodies:\n - \x07\n", 2, "control characters", "U+0007")
broken("tab as indent", "bodies:\n\t- name: a\n", 2, "not YAML", "indent with spaces, not tabs")
broken("open bracket", "bodies: [\n", 2, "not YAML", "flow")
broken("open quote", 'bodies: "abc\n', 2, "not YAML", "quoted scalar")
broken("wrong indent", "bodies:\n  - name: a\n shape: b\n", 3, "not YAML")
broken("two colons", "bodies: a: b\n", 1, "not YAML", "mapping values are not allowed")
broken("two documents", "bodies: []\n---\nbodies: []\n", 2, "one document")
broken("unknown alias", "bodies: *here\n", 1, "alias *here has no anchor")
broken("alias in itself", "bodies: &a\n  - *a\n", 2, "alias *a lies inside")
broken("tag that makes an object", 'bodies: !!python/object/apply:os.system ["exit 1"]\n', 1, "tags", "python/object")
broken("tag of a number", "bodies:\n - shape: {Sphere: {radius: !!float 1}}\n", 2, "tags", "not allowed")
broken("tag directive", "%TAG ! tag:example.org,2000:\n---\nbodies: []\n", 1, "directive", "not allowed")
broken("list as key", "? [a, b]\n: 1\n", 1, "a key must be a word")
broken("key given twice", "bodies: []\nlights: []\nbodies: []\n", 3, "'bodies' is given twice", "line 1")
broken("field given twice", sphere("{radius: 1,\n   radius: 2}"), 3, "'radius' is given twice", "line 2")
broken("deep brackets", "bodies: " + "[" * 300 + "]" * 300, 1, "nested deeper than 250")
broken("deep mappings", "bodies: " + "{a: " * 300 + "1" + "}" * 300, 1, "nested deeper than 250")
broken(
    "billion laughs",
    "a0: &a0 [1,1,1,1,1,1,1,1,1,1]\n"
    + "".join(f"a{i}: &a{i} [{','.join([f'*a{i - 1}'] * 10)}]\n" for i in range(1, 12)),
    6,
    "more than 1,000,000 values, aliases expanded",
)

# The file as a whole --------------------------------------------------------------------------------
broken("a word", "hello\n", 1, "must be a mapping with", "bodies", "got 'hello'")
broken("a list", "- Sphere\n", 1, "must be a mapping with", "got ['Sphere']")
broken("a number", "3\n", 1, "must be a mapping with", "got 3")
broken("no bodies", "lights: []\n", 1, "bodies must be given")
broken("unknown section", "bodies: []\ncamra: {}\n", 2, "unknown key 'camra'", "did you mean 'camera'?")
broken("merge key", "<<: {a: 1}\nbodies: []\n", 1, "unknown key '<<'")
broken("newer format", "conicoid: 2\nbodies: []\n", 1, "conicoid: must be 1", "got 2")
broken("format as text", "conicoid: one\nbodies: []\n", 1, "conicoid: must be an integer", "got 'one'")
broken("bodies as a mapping", "bodies:\n  a: {shape: {Sphere: {}}}\n", 2, "bodies: must be a list")
broken("bodies as a word", "bodies: many\n", 1, "bodies: must be a list", "got 'many'")

# Bodies ---------------------------------------------------------------------------------------------
broken("a body without shape", body("name: a"), 2, 'body "a": shape must be given')
broken("a body that is a word", body("Sphere"), 2, "bodies[0]: must be a mapping with name, shape", "got 'Sphere'")
broken("misspelt key", body("shap: {Sphere: {}}"), 2, "unknown key 'shap'", "did you mean 'shape'?")
broken("shape where a body is wanted", body("Sphere: {radius: 1}"), 2, "unknown key 'Sphere'", "name, shape")
broken("name is a number", body("{name: 5, shape: {Sphere: {}}}"), 2, "name: must be a text, got 5", "quote it")
broken("name is empty", body("{name: '', shape: {Sphere: {}}}"), 2, "name: must be a text, got ''")
broken(
    "name taken",
    "bodies:\n  - {name: a, shape: {Sphere: {}}}\n  - {name: a, shape: {Sphere: {}}}\n",
    3,
    "name 'a' is taken by the body in line 2",
)
broken("unknown material", body("{shape: {Sphere: {}}, material: red}"), 2, "unknown material 'red'")
broken(
    "misspelt material",
    "materials: {glossy: {phong: {}}}\nbodies:\n  - {shape: {Sphere: {}}, material: glosy}\n",
    3,
    "unknown material 'glosy'",
    "did you mean 'glossy'?",
)
broken("material is a number", body("{shape: {Sphere: {}}, material: 3}"), 2, "material: must be a material", "got 3")

# Shapes ---------------------------------------------------------------------------------------------
broken("unknown shape", body("shape: {Spere: {}}"), 2, "unknown shape 'Spere'", "did you mean 'Sphere'?")
broken("torus", body("shape: {Torus: {}}"), 2, "unknown shape 'Torus'")
broken("lower case", body("shape: {sphere: {}}"), 2, "unknown shape 'sphere'", "did you mean 'Sphere'?")
broken("bare class name", body("shape: Sphere"), 2, "must be a mapping, {Sphere: {...}}")
broken("shape is a number", body("shape: 7"), 2, "must be a shape", "got 7")
broken("shape is null", body("shape:"), 2, "must be a shape", "got nothing")
broken("two shapes in one", body("shape: {Sphere: {}, Box: {}}"), 2, "one shape as its key", "got 2: Sphere, Box")
broken("no shape at all", body("shape: {}"), 2, "one shape as its key", "got none")
broken("unknown field", sphere("{radios: 1}"), 2, "Sphere: unknown key 'radios'", "did you mean 'radius'?")
broken("radius is text", sphere("{radius: big}"), 2, "Sphere: radius: must be a number, got 'big'")
broken("radius in quotes", sphere("{radius: '1'}"), 2, "Sphere: radius: must be a number, got '1' in quotes")
broken("radius is a truth value", sphere("{radius: true}"), 2, "Sphere: radius: must be a number, got true")
broken("radius is null", sphere("{radius: null}"), 2, "Sphere: radius: must be a number, got null")
broken("radius is a list", sphere("{radius: [1]}"), 2, "Sphere: radius: must be a number, got [1]")
broken("radius is zero", sphere("{center: [0, 0, 0],\n   radius: 0}"), 3, "Sphere: radius must be > 0, got 0.0")
broken("radius is negative", sphere("{radius: -2}"), 2, "Sphere: radius must be > 0, got -2.0")
broken("radius is NaN", sphere("{radius: .nan}"), 2, "Sphere: radius: must be a number, not NaN, got .nan")
broken("radius is infinite", sphere("{radius: .inf}"), 2, "Sphere: radius must be finite, got inf")
broken("radius overflows", sphere("{radius: 1e999}"), 2, "number that float64 can hold, got 1e999")
broken("radius underflows", sphere("{radius: 1e-999}"), 2, "number that float64 can hold, got 1e-999")
broken("comma in a number", sphere("{radius: 1.234.5}"), 2, "must be a number, got '1.234.5'")
broken("underscore in a number", sphere("{radius: 1_000}"), 2, "must be a number, got '1_000'")
broken("center is short", sphere("{center: [0, 0]}"), 2, "Sphere: center: must be 3 numbers, got 2: [0, 0]")
broken("center is one number", sphere("{center: 0}"), 2, "Sphere: center: must be 3 numbers, got 0")
broken("center holds a word", sphere("{center: [0,\n   up, 0]}"), 3, "center[1]: must be a number, got 'up'")
broken("fields as a list", sphere("[1]"), 2, "Sphere: must be a mapping with radius, center, got [1]")
broken("fields as a number", sphere("1"), 2, "Sphere: must be a mapping with radius, center, got 1")
broken("missing field", body("shape: {Cylinder: {start: [0, 0, 0], radius: 1}}"), 2, "Cylinder: end must be given")
broken("missing fields", body("shape: {HalfSpace: {}}"), 2, "HalfSpace: normal and offset must be given")
broken(
    "axis without length", body("shape: {Cylinder: {start: [1, 1, 1], end: [1, 1, 1], radius: 1}}"), 2, "Cylinder: end"
)
broken("range upside down", body("shape: {Ellipsoid: {z_range: [2, 1]}}"), 2, "Ellipsoid: z_range must have low < high")
broken("range of one", body("shape: {Ellipsoid: {z_range: [1]}}"), 2, "Ellipsoid: z_range: must be 2 numbers")
broken(
    "radii hold a zero", body("shape:\n      Ellipsoid:\n        radii: [1, 0, 1]"), 4, "radii[1] must be > 0, got 0.0"
)
broken(
    "flag is a text",
    body("shape: {Plane: {normal: [0, 0, 1], offset: 0, one_sided: no}}"),
    2,
    "must be true or false, got 'no'",
)
broken("open polygon", body("shape: {Polygon: {vertices: [[0, 0, 0], [1, 0, 0]]}}"), 2, "vertices must have at least 3")
broken("bent polygon", body("shape: {Polygon: {vertices: [[0, 0, 0], [1, 0, 0], [1, 1, 1], [0, 1, 0]]}}"), 2, "plane")
broken("unknown coefficient", body("shape: {Quadric: {coefficients: {xx: 1, zw: 2}}}"), 2, "Quadric", "zw")
broken("matrix is small", body("shape: {Quadric: {matrix: [[1, 0], [0, 1]]}}"), 2, "Quadric: matrix: must be 4 items")
broken(
    "within no box",
    body("shape: {ParabolicCylinder: {G: 1, within: {Sphere: {}}}}"),
    2,
    "must be a Box",
    "got Sphere, a solid",
)

# Booleans and references ----------------------------------------------------------------------------
broken("Boolean of nothing", body("shape: {Union: []}"), 2, "Union: must be a list of at least one solid, got []")
broken("Boolean of one mapping", body("shape: {Union: {Sphere: {}}}"), 2, "Union: must be a list of at least one solid")
broken(
    "Boolean of a number", body("shape: {Difference: [{Sphere: {}}, 1]}"), 2, "Difference[1]: must be a shape", "got 1"
)
broken(
    "Boolean with a mistake inside",
    body("shape:\n      Union:\n        - Sphere: {}\n        - Difference: [{Sphere: {}}, {Box: {lo: [0, 0, 0]}}]"),
    5,
    "Union[1]: Difference[1]: Box: unknown key 'lo'",
    "did you mean 'low'?",
)
broken(
    "Boolean of a sheet",
    body("shape: {Union: [{Disc: {center: [0, 0, 0], normal: [0, 0, 1], radius: 1}}]}"),
    2,
    "Disc is a sheet",
)
broken(
    "balls in a Boolean",
    body("shape: {Complement: {Spheres: {centers: [], radii: []}}}"),
    2,
    "must be solids, got Spheres",
)
broken(
    "sheet clipped by a sheet",
    body(
        "shape: {ClippedSheet: {base: {Plane: {normal: [0, 0, 1], offset: 0}}, solid: {Plane: {normal: [0, 0, 1], offset: 0}}}}"
    ),
    2,
    "solid: must be a solid",
    "got Plane, a sheet",
)
broken(
    "side that does not exist",
    body("shape: {ClippedSheet: {base: {Plane: {normal: [0, 0, 1], offset: 0}}, solid: {Box: {}},\n   keep: in}}"),
    3,
    "ClippedSheet: keep: must be 'inside' or 'outside', got 'in'",
)
broken(
    "paint without a material",
    body("shape: {Painted: {operand: {Sphere: {}}}}"),
    2,
    "Painted: material must be given",
)
broken(
    "paint on a list",
    body("shape: {Painted: [{Sphere: {}}, {matte: {}}]}"),
    2,
    "Painted: must be a mapping with operand, material",
)
broken(
    "paint on a sheet",
    body("shape: {Painted: {operand: {Plane: {normal: [0, 0, 1], offset: 0}}, material: {matte: {}}}}"),
    2,
    "Painted: operand: must be a solid",
    "got Plane, a sheet",
)
broken(
    "unknown paint",
    "materials: {copper: {metal: {}}}\nbodies:\n  - shape: {Painted: {operand: {Sphere: {}},\n     material: coper}}\n",
    4,
    "Painted: material: unknown material 'coper'",
    "did you mean 'copper'?",
)
broken(
    "paint is a color",
    body("shape: {Painted: {operand: {Sphere: {}}, material: [1, 0, 0]}}"),
    2,
    "Painted: material: must be a material such as {matte: {...}}, or the name of one under `materials`",
)
broken(
    "paint with a mistake inside",
    body("shape: {Painted: {operand: {Sphere: {}}, material: {matte: {colour: red}}}}"),
    2,
    "Painted: material: matte: unknown key 'colour'",
    "did you mean 'color'?",
)
broken(
    "unknown reference",
    "shapes: {wheel: {Sphere: {}}}\nbodies:\n  - shape: weel\n",
    3,
    "unknown shape 'weel'",
    "did you mean 'wheel'?",
)
broken("shapes as a list", "shapes: [{Sphere: {}}]\nbodies: []\n", 1, "shapes: must be a mapping from names")
broken("a shape's name is a number", "shapes: {1: {Sphere: {}}}\nbodies: []\n", 1, "name must be a text, got 1")
broken(
    "mistake in an unused shape",
    "bodies: []\nshapes:\n  a: {Sphere: {radius: -1}}\n",
    3,
    'shape "a": Sphere: radius must be > 0',
)
broken("shape refers to itself", "shapes: {a: a}\nbodies: []\n", 1, "circle: a → a")
broken(
    "circle of three",
    "shapes:\n  a: {Union: [b]}\n  b: {Complement: c}\n  c: {Difference: [a, b]}\nbodies: []\n",
    4,
    "shapes refer to each other in a circle: a → b → c → a",
)
broken(
    "references that explode",
    "shapes:\n  s0: {Sphere: {}}\n"
    + "".join(f"  s{i}: {{Union: [s{i - 1}, s{i - 1}]}}\n" for i in range(1, 31))
    + "bodies: []\n",
    21,  # 2^20 - 1 parts
    "more than 1,000,000 parts, references written out",
)
broken(
    "deep Boolean",
    body("shape: " + "{Complement: " * 120 + "{Sphere: {}}" + "}" * 120),
    2,
    "nested deeper than 100 levels",
)
broken(
    "deep references to what comes later",
    "shapes:\n"
    + "".join(f"  s{i}: {{Complement: s{i + 1}}}\n" for i in range(300))
    + "  s300: {Sphere: {}}\nbodies: []\n",
    52,
    "nested deeper than 100 levels",
    "each before its use",
)

# Motions --------------------------------------------------------------------------------------------
broken(
    "move is a mapping", body("{shape: {Sphere: {}}, move: {translate: [1, 0, 0]}}"), 2, "move: must be a list of steps"
)
broken(
    "unknown step",
    body("{shape: {Sphere: {}}, move: [{translat: [1, 0, 0]}]}"),
    2,
    "unknown step 'translat'",
    "did you mean 'translate'?",
)
broken(
    "two steps in one",
    body("{shape: {Sphere: {}}, move: [{scale: 2, translate: [1, 0, 0]}]}"),
    2,
    "move[0]: must be one of translate",
)
broken(
    "short step", body("{shape: {Sphere: {}}, move: [{translate: [1, 0]}]}"), 2, "translate: must be 3 numbers, got 2"
)
broken(
    "scale by zero",
    body("{shape: {Sphere: {}}, move: [{scale: [1, 0, 1]}]}"),
    2,
    "move[0]: scale: factors must not be zero",
)
broken(
    "rotate without axis",
    body("{shape: {Sphere: {}}, move: [{rotate: {degrees: 3}}]}"),
    2,
    "rotate: axis must be given",
)
broken(
    "rotate about nothing",
    body("{shape: {Sphere: {}}, move: [{rotate: {axis: [0, 0, 0], degrees: 3}}]}"),
    2,
    "axis must not be zero",
)
broken(
    "singular matrix",
    body("{shape: {Sphere: {}}, move: [{transform: [[1, 0, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}]}"),
    2,
    "transform: matrix must be invertible",
)
broken(
    "projective matrix",
    body("{shape: {Sphere: {}}, move: [{transform: [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 1, 1]]}]}"),
    2,
    "transform: matrix must be affine",
)
broken(
    "overflowing motion", body("{shape: {Sphere: {}}, move: [{scale: 1e300}, {scale: 1e300}]}"), 2, "motion overflows"
)
broken(
    "too many steps",
    body("{shape: {Sphere: {}}, move: [" + "{scale: 2}, " * 1001 + "]}"),
    2,
    "at most 1000 steps, got 1001",
)

# Bulk spheres and files beside the scene ------------------------------------------------------------
broken("balls without radii", body("shape: {Spheres: {centers: [[0, 0, 0]]}}"), 2, "either centers and radii, or file")
broken(
    "balls and a file",
    body("shape: {Spheres: {centers: [], radii: [], file: a.npy}}"),
    2,
    "either centers and radii, or file",
)
broken(
    "more balls than radii",
    body("shape: {Spheres: {centers: [[0, 0, 0], [1, 1, 1]], radii: [1]}}"),
    2,
    "Spheres: radii must have shape (2,)",
)
broken(
    "a ball of radius 0",
    body("shape: {Spheres: {centers: [[0, 0, 0], [1, 1, 1]], radii: [1,\n 0]}}"),
    3,
    "radii[1] must be > 0",
)
broken("missing file", body("shape: {Spheres: {file: none.npy}}"), 2, "is not an existing file", "none.npy")
broken("absolute path", body("shape: {Spheres: {file: /etc/passwd}}"), 2, "must be a relative path", "/etc/passwd")
broken("path that leaves", body("shape: {Spheres: {file: ../../etc/passwd}}"), 2, "must stay inside the scene's folder")
broken("backslashes", body(r"shape: {Spheres: {file: data\balls.npy}}"), 2, "relative path with forward slashes")
broken("drive letter", body("shape: {Spheres: {file: 'C:/balls.npy'}}"), 2, "must be a relative path")
broken("file is a number", body("shape: {Spheres: {file: 7}}"), 2, "file: must be a text, got 7")

# Materials, lights, camera, background --------------------------------------------------------------
broken("materials as a list", "materials: [{phong: {}}]\nbodies: []\n", 1, "materials: must be a mapping from names")
broken(
    "unknown look", "materials: {a: {fong: {}}}\nbodies: []\n", 1, "unknown material 'fong'", "did you mean 'phong'?"
)
broken("two looks", "materials: {a: {phong: {}, glass: {}}}\nbodies: []\n", 1, 'material "a": must be a material')
broken(
    "color too bright",
    "materials: {a: {phong: {color: [2, 0, 0]}}}\nbodies: []\n",
    1,
    "phong: color[0] must be in [0, 1], got 2.0",
)
broken(
    "color as a comment",
    "materials:\n  a:\n    matte:\n      color: #ff0000\nbodies: []\n",
    4,
    "got nothing",
    "# begins a comment",
)
broken("unknown color", "materials: {a: {matte: {color: redd}}}\nbodies: []\n", 1, "color must be", "got 'redd'")
broken(
    "unknown pattern", "materials: {a: {matte: {color: {Chequer: {}}}}}\nbodies: []\n", 1, "unknown Checker 'Chequer'"
)
broken(
    "pattern with a mistake",
    "materials: {a: {matte: {color: {Checker: {scale: 0}}}}}\nbodies: []\n",
    1,
    "Checker: scale must be > 0",
)
broken(
    "index of zero", "materials: {a: {glass: {refractive_index: 0}}}\nbodies: []\n", 1, "refractive_index must be > 0"
)
broken(
    "unknown highlight",
    "materials: {a: {Material: {highlight: shiny}}}\nbodies: []\n",
    1,
    "must be 'phong' or 'blinn_phong', got 'shiny'",
)
broken("lights as a mapping", "lights: {PointLight: {position: [0, 0, 1]}}\nbodies: []\n", 1, "lights: must be a list")
broken(
    "unknown light",
    "lights: [{Pointlite: {}}]\nbodies: []\n",
    1,
    "unknown light 'Pointlite'",
    "did you mean 'PointLight'?",
)
broken(
    "light without a place",
    "lights:\n  - PointLight: {}\nbodies: []\n",
    2,
    "lights[0]: PointLight: position must be given",
)
broken("dark light", "lights: [{AmbientLight: {intensity: -1}}]\nbodies: []\n", 1, "intensity must be >= 0, got -1.0")
broken(
    "wide spot",
    "lights: [{SpotLight: {position: [0, 0, 1], direction: [0, 0, -1], angle: 200}}]\nbodies: []\n",
    1,
    "angle must be in (0, 180]",
)
broken("camera is a word", "camera: there\nbodies: []\n", 1, "camera: must be the fields of a camera", "got 'there'")
broken("camera without a target", "camera: {position: [1, 2, 3]}\nbodies: []\n", 1, "Camera: look_at must be given")
broken(
    "camera looks at itself",
    "camera: {position: [1, 2, 3], look_at: [1, 2, 3]}\nbodies: []\n",
    1,
    "look_at must differ from position",
)
broken(
    "camera too wide",
    "camera: {position: [1, 2, 3], look_at: [0, 0, 0],\n  field_of_view: 180}\nbodies: []\n",
    2,
    "field_of_view must be in (0, 180)",
)
broken(
    "camera misspelt",
    "camera: {position: [1, 2, 3], lookat: [0, 0, 0]}\nbodies: []\n",
    1,
    "unknown key 'lookat'",
    "did you mean 'look_at'?",
)
broken("unknown camera", "camera: {FisheyeCamera: {}}\nbodies: []\n", 1, "unknown camera 'FisheyeCamera'")
broken("background is a number", "background: 3\nbodies: []\n", 1, "background: must be 3 numbers, or a text", "got 3")
broken(
    "background is half a color", "background: [1, 1]\nbodies: []\n", 1, "background: must be 3 numbers", "got [1, 1]"
)
