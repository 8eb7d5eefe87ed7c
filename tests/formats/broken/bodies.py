"""Bodies, and shapes that stand alone."""

from .case import body, broken, sphere

# Bodies -------------------------------------------------------------------------------------------
CASES = [
    broken("a body without shape", body("name: a"), 2, 'body "a": shape must be given'),
    broken("a body that is a word", body("Sphere"), 2, "bodies[0]: must be a mapping with name, shape", "got 'Sphere'"),
    broken("misspelt key", body("shap: {Sphere: {}}"), 2, "unknown key 'shap'", "did you mean 'shape'?"),
    broken("shape where a body is wanted", body("Sphere: {radius: 1}"), 2, "unknown key 'Sphere'", "name, shape"),
    broken("name is a number", body("{name: 5, shape: {Sphere: {}}}"), 2, "name: must be a text, got 5"),
    broken("name is empty", body("{name: '', shape: {Sphere: {}}}"), 2, "name: must be a text, got ''"),
    broken(
        "name taken",
        "bodies:\n  - {name: a, shape: {Sphere: {}}}\n  - {name: a, shape: {Sphere: {}}}\n",
        3,
        "name 'a' is taken by the body in line 2",
    ),
    broken("unknown material", body("{shape: {Sphere: {}}, material: ruby}"), 2, "got 'ruby'"),
    broken(
        "misspelt material",
        "materials: {glossy: {phong: {}}}\nbodies:\n  - {shape: {Sphere: {}}, material: glosy}\n",
        3,
        "got 'glosy'",
        "did you mean 'glossy'?",
    ),
    broken(
        "material is a number", body("{shape: {Sphere: {}}, material: 3}"), 2, "material: must be a material", "got 3"
    ),
    # Shapes -------------------------------------------------------------------------------------------
    broken("unknown shape", body("shape: {Spere: {}}"), 2, "unknown shape 'Spere'", "did you mean 'Sphere'?"),
    broken("torus", body("shape: {Torus: {}}"), 2, "unknown shape 'Torus'"),
    broken("lower case", body("shape: {sphere: {}}"), 2, "unknown shape 'sphere'", "did you mean 'Sphere'?"),
    broken("bare class name", body("shape: Sphere"), 2, "must be a mapping, {Sphere: {...}}"),
    broken("shape is a number", body("shape: 7"), 2, "must be a shape", "got 7"),
    broken("shape is null", body("shape:"), 2, "must be a shape", "got nothing"),
    broken("two shapes in one", body("shape: {Sphere: {}, Box: {}}"), 2, "one shape as its key", "got 2: Sphere, Box"),
    broken("no shape at all", body("shape: {}"), 2, "one shape as its key", "got none"),
    broken("unknown field", sphere("{radios: 1}"), 2, "Sphere: unknown key 'radios'", "did you mean 'radius'?"),
    broken("radius is text", sphere("{radius: big}"), 2, "Sphere: radius: must be a number, got 'big'"),
    broken("radius in quotes", sphere("{radius: '1'}"), 2, "Sphere: radius: must be a number, got '1'"),
    broken("radius is a truth value", sphere("{radius: true}"), 2, "Sphere: radius: must be a number, got true"),
    broken("radius is null", sphere("{radius: null}"), 2, "Sphere: radius: must be a number, got null"),
    broken("radius is a list", sphere("{radius: [1]}"), 2, "Sphere: radius: must be a number, got [1]"),
    broken("radius is zero", sphere("{center: [0, 0, 0],\n   radius: 0}"), 3, "Sphere: radius must be > 0, got 0.0"),
    broken("radius is negative", sphere("{radius: -2}"), 2, "Sphere: radius must be > 0, got -2.0"),
    broken("radius is NaN", sphere("{radius: .nan}"), 2, "Sphere: radius: must be a number, not NaN, got .nan"),
    broken("radius is infinite", sphere("{radius: .inf}"), 2, "Sphere: radius must be finite, got inf"),
    broken("radius overflows", sphere("{radius: 1e999}"), 2, "number that float64 can hold, got 1e999"),
    broken("radius underflows", sphere("{radius: 1e-999}"), 2, "number that float64 can hold, got 1e-999"),
    broken("comma in a number", sphere("{radius: 1.234.5}"), 2, "must be a number, got '1.234.5'"),
    broken("underscore in a number", sphere("{radius: 1_000}"), 2, "must be a number, got '1_000'"),
    broken("center is short", sphere("{center: [0, 0]}"), 2, "Sphere: center: must be 3 numbers, got 2: [0, 0]"),
    broken("center is one number", sphere("{center: 0}"), 2, "Sphere: center: must be 3 numbers, got 0"),
    broken("center holds a word", sphere("{center: [0,\n   up, 0]}"), 3, "center[1]: must be a number, got 'up'"),
    broken("fields as a list", sphere("[1]"), 2, "Sphere: must be a mapping with radius, center, got [1]"),
    broken("fields as a number", sphere("1"), 2, "Sphere: must be a mapping with radius, center, got 1"),
    broken("missing field", body("shape: {Cylinder: {start: [0, 0, 0], radius: 1}}"), 2, "Cylinder: end must be given"),
    broken("missing fields", body("shape: {HalfSpace: {}}"), 2, "HalfSpace: normal and offset must be given"),
    broken(
        "axis without length",
        body("shape: {Cylinder: {start: [1, 1, 1], end: [1, 1, 1], radius: 1}}"),
        2,
        "Cylinder: end",
    ),
    broken(
        "range upside down", body("shape: {Ellipsoid: {z_range: [2, 1]}}"), 2, "Ellipsoid: z_range must have low < high"
    ),
    broken("range of one", body("shape: {Ellipsoid: {z_range: [1]}}"), 2, "Ellipsoid: z_range: must be 2 numbers"),
    broken(
        "radii hold a zero",
        body("shape:\n      Ellipsoid:\n        radii: [1, 0, 1]"),
        4,
        "radii[1] must be > 0, got 0.0",
    ),
    broken(
        "flag is a text",
        body("shape: {Plane: {normal: [0, 0, 1], offset: 0, one_sided: no}}"),
        2,
        "must be true or false, got 'no'",
    ),
    broken(
        "open polygon", body("shape: {Polygon: {vertices: [[0, 0, 0], [1, 0, 0]]}}"), 2, "vertices must have at least 3"
    ),
    broken(
        "bent polygon", body("shape: {Polygon: {vertices: [[0, 0, 0], [1, 0, 0], [1, 1, 1], [0, 1, 0]]}}"), 2, "plane"
    ),
    broken("unknown coefficient", body("shape: {Quadric: {coefficients: {xx: 1, zw: 2}}}"), 2, "Quadric", "zw"),
    broken(
        "matrix is small", body("shape: {Quadric: {matrix: [[1, 0], [0, 1]]}}"), 2, "Quadric: matrix: must be 4 items"
    ),
    broken(
        "within no box",
        body("shape: {ParabolicCylinder: {G: 1, within: {Sphere: {}}}}"),
        2,
        "must be a Box",
        "got Sphere, a solid",
    ),
]
