"""Booleans, clipped sheets, paint, and references to shapes."""

from .case import body, broken

CASES = [
    broken("Boolean of nothing", body("shape: {Union: []}"), 2, "Union: must be a list of at least one solid, got []"),
    broken(
        "Boolean of one mapping", body("shape: {Union: {Sphere: {}}}"), 2, "Union: must be a list of at least one solid"
    ),
    broken(
        "Boolean of a number",
        body("shape: {Difference: [{Sphere: {}}, 1]}"),
        2,
        "Difference[1]: must be a shape",
        "got 1",
    ),
    broken(
        "Boolean with a mistake inside",
        body(
            "shape:\n      Union:\n        - Sphere: {}\n        - Difference: [{Sphere: {}}, {Box: {lo: [0, 0, 0]}}]"
        ),
        5,
        "Union[1]: Difference[1]: Box: unknown key 'lo'",
        "did you mean 'low'?",
    ),
    broken(
        "Boolean of a sheet",
        body("shape: {Union: [{Disc: {center: [0, 0, 0], normal: [0, 0, 1], radius: 1}}]}"),
        2,
        "Disc is a sheet",
    ),
    broken(
        "balls in a Boolean",
        body("shape: {Complement: {Spheres: {centers: [], radii: []}}}"),
        2,
        "must be solids, got Spheres",
    ),
    broken(
        "sheet clipped by a sheet",
        body(
            "shape: {ClippedSheet: {base: {Plane: {normal: [0, 0, 1], offset: 0}}, solid: {Plane: {normal: [0, 0, 1], offset: 0}}}}"
        ),
        2,
        "solid: must be a solid",
        "got Plane, a sheet",
    ),
    broken(
        "side that does not exist",
        body("shape: {ClippedSheet: {base: {Plane: {normal: [0, 0, 1], offset: 0}}, solid: {Box: {}},\n   keep: in}}"),
        3,
        "ClippedSheet: keep: must be 'inside' or 'outside', got 'in'",
    ),
    broken(
        "paint without a material",
        body("shape: {Painted: {operand: {Sphere: {}}}}"),
        2,
        "Painted: material must be given",
    ),
    broken(
        "paint on a list",
        body("shape: {Painted: [{Sphere: {}}, {matte: {}}]}"),
        2,
        "Painted: must be a mapping with operand, material",
    ),
    broken(
        "paint on a sheet",
        body("shape: {Painted: {operand: {Plane: {normal: [0, 0, 1], offset: 0}}, material: {matte: {}}}}"),
        2,
        "Painted: operand: must be a solid",
        "got Plane, a sheet",
    ),
    broken(
        "unknown paint",
        "materials: {copper: {metal: {}}}\nbodies:\n  - shape: {Painted: {operand: {Sphere: {}},\n     material: coper}}\n",
        4,
        "Painted: material: must be a material such as",
        "did you mean 'copper'?",
    ),
    broken(
        "paint is a color",
        body("shape: {Painted: {operand: {Sphere: {}}, material: [1, 0, 0]}}"),
        2,
        "Painted: material: must be a material such as {matte: {...}}, or the name of one under `materials`",
    ),
    broken(
        "paint with a mistake inside",
        body("shape: {Painted: {operand: {Sphere: {}}, material: {matte: {colour: red}}}}"),
        2,
        "Painted: material: matte: unknown key 'colour'",
        "did you mean 'color'?",
    ),
    broken(
        "unknown reference",
        "shapes: {wheel: {Sphere: {}}}\nbodies:\n  - shape: weel\n",
        3,
        "unknown shape 'weel'",
        "did you mean 'wheel'?",
    ),
    broken("shapes as a list", "shapes: [{Sphere: {}}]\nbodies: []\n", 1, "shapes: must be a mapping from names"),
    broken("a shape's name is a number", "shapes: {1: {Sphere: {}}}\nbodies: []\n", 1, "name must be a text, got 1"),
    broken(
        "mistake in an unused shape",
        "bodies: []\nshapes:\n  a: {Sphere: {radius: -1}}\n",
        3,
        'shape "a": Sphere: radius must be > 0',
    ),
    broken("shape refers to itself", "shapes: {a: a}\nbodies: []\n", 1, "circle: a → a"),
    broken(
        "circle of three",
        "shapes:\n  a: {Union: [b]}\n  b: {Complement: c}\n  c: {Difference: [a, b]}\nbodies: []\n",
        4,
        "shapes refer to each other in a circle: a → b → c → a",
    ),
    broken(
        "references that explode",
        "shapes:\n  s0: {Sphere: {}}\n"
        + "".join(f"  s{i}: {{Union: [s{i - 1}, s{i - 1}]}}\n" for i in range(1, 31))
        + "bodies: []\n",
        21,  # 2^20 - 1 parts
        "more than 1,000,000 parts, references written out",
    ),
    broken(
        "deep Boolean",
        body("shape: " + "{Complement: " * 120 + "{Sphere: {}}" + "}" * 120),
        2,
        "nested deeper than 100 levels",
    ),
    broken(
        "deep references to what comes later",
        "shapes:\n"
        + "".join(f"  s{i}: {{Complement: s{i + 1}}}\n" for i in range(300))
        + "  s300: {Sphere: {}}\nbodies: []\n",
        52,
        "nested deeper than 100 levels",
        "each before its use",
    ),
]
