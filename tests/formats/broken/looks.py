"""Materials, lights, camera and background."""

from .case import broken

CASES = [
    broken(
        "materials as a list", "materials: [{phong: {}}]\nbodies: []\n", 1, "materials: must be a mapping from names"
    ),
    broken(
        "unknown look",
        "materials: {a: {phonk: {}}}\nbodies: []\n",
        1,
        "unknown material 'phonk'",
        "did you mean 'phong'?",
    ),
    broken("two looks", "materials: {a: {phong: {}, glass: {}}}\nbodies: []\n", 1, 'material "a": must be a material'),
    broken(
        "color too bright",
        "materials: {a: {phong: {color: [2, 0, 0]}}}\nbodies: []\n",
        1,
        "phong: color[0] must be in [0, 1], got 2.0",
    ),
    broken(
        "color as a comment",
        "materials:\n  a:\n    matte:\n      color: #ff0000\nbodies: []\n",
        4,
        "got nothing",
        "# begins a comment",
    ),
    broken("unknown color", "materials: {a: {matte: {color: redd}}}\nbodies: []\n", 1, "color must be", "got 'redd'"),
    broken(
        "unknown pattern",
        "materials: {a: {matte: {color: {Chequer: {}}}}}\nbodies: []\n",
        1,
        "unknown pattern 'Chequer'",
    ),
    broken(
        "pattern with a mistake",
        "materials: {a: {matte: {color: {Checker: {scale: 0}}}}}\nbodies: []\n",
        1,
        "Checker: scale must be > 0",
    ),
    broken(
        "index of zero",
        "materials: {a: {glass: {refractive_index: 0}}}\nbodies: []\n",
        1,
        "refractive_index must be > 0",
    ),
    broken(
        "unknown highlight",
        "materials: {a: {Material: {highlight: shiny}}}\nbodies: []\n",
        1,
        "must be 'phong' or 'blinn_phong', got 'shiny'",
    ),
    broken(
        "lights as a mapping", "lights: {PointLight: {position: [0, 0, 1]}}\nbodies: []\n", 1, "lights: must be a list"
    ),
    broken(
        "unknown light",
        "lights: [{Pointlite: {}}]\nbodies: []\n",
        1,
        "unknown light 'Pointlite'",
        "did you mean 'PointLight'?",
    ),
    broken(
        "light without a place",
        "lights:\n  - PointLight: {}\nbodies: []\n",
        2,
        "lights[0]: PointLight: position must be given",
    ),
    broken(
        "dark light", "lights: [{AmbientLight: {intensity: -1}}]\nbodies: []\n", 1, "intensity must be >= 0, got -1.0"
    ),
    broken(
        "wide spot",
        "lights: [{SpotLight: {position: [0, 0, 1], direction: [0, 0, -1], angle: 200}}]\nbodies: []\n",
        1,
        "angle must be in (0, 180]",
    ),
    broken(
        "camera is a word", "camera: there\nbodies: []\n", 1, "camera: must be the fields of a camera", "got 'there'"
    ),
    broken(
        "camera without a target", "camera: {position: [1, 2, 3]}\nbodies: []\n", 1, "Camera: look_at must be given"
    ),
    broken(
        "camera looks at itself",
        "camera: {position: [1, 2, 3], look_at: [1, 2, 3]}\nbodies: []\n",
        1,
        "look_at must differ from position",
    ),
    broken(
        "camera too wide",
        "camera: {position: [1, 2, 3], look_at: [0, 0, 0],\n  field_of_view: 180}\nbodies: []\n",
        2,
        "field_of_view must be in (0, 180)",
    ),
    broken(
        "camera misspelt",
        "camera: {position: [1, 2, 3], lookat: [0, 0, 0]}\nbodies: []\n",
        1,
        "unknown key 'lookat'",
        "did you mean 'look_at'?",
    ),
    broken("unknown camera", "camera: {PanoramaCamera: {}}\nbodies: []\n", 1, "unknown camera 'PanoramaCamera'"),
    broken(
        "background is a number", "background: 3\nbodies: []\n", 1, "background: must be 3 numbers, or a text", "got 3"
    ),
    broken(
        "background is half a color",
        "background: [1, 1]\nbodies: []\n",
        1,
        "background: must be 3 numbers",
        "got [1, 1]",
    ),
    broken(
        "background of less than no light",
        "bodies: []\nbackground: [1,\n  -1, 0]\n",
        3,
        "scene: background[1] must be >= 0, got -1.0",
    ),
    broken("background of no known color", "bodies: []\nbackground: redd\n", 2, "background must be", "got 'redd'"),
    broken(
        "sky of less than no light",
        "bodies: []\nbackground: {Sky: {horizon: [1, 1, -0.5]}}\n",
        2,
        "Sky: horizon[2] must be >= 0, got -0.5",
    ),
]
