"""Motions, balls in bulk, and files beside the scene."""

from .case import body, broken

# Motions ------------------------------------------------------------------------------------------
CASES = [
    broken(
        "move is a mapping",
        body("{shape: {Sphere: {}}, move: {translate: [1, 0, 0]}}"),
        2,
        "move: must be a list of steps",
    ),
    broken(
        "unknown step",
        body("{shape: {Sphere: {}}, move: [{translat: [1, 0, 0]}]}"),
        2,
        "unknown step 'translat'",
        "did you mean 'translate'?",
    ),
    broken(
        "two steps in one",
        body("{shape: {Sphere: {}}, move: [{scale: 2, translate: [1, 0, 0]}]}"),
        2,
        "move[0]: must be one of translate",
    ),
    broken(
        "short step",
        body("{shape: {Sphere: {}}, move: [{translate: [1, 0]}]}"),
        2,
        "translate: must be 3 numbers, got 2",
    ),
    broken(
        "scale by zero",
        body("{shape: {Sphere: {}}, move: [{scale: [1, 0, 1]}]}"),
        2,
        "move[0]: scale: factors must not be zero",
    ),
    broken(
        "rotate without axis",
        body("{shape: {Sphere: {}}, move: [{rotate: {degrees: 3}}]}"),
        2,
        "rotate: axis must be given",
    ),
    broken(
        "rotate about nothing",
        body("{shape: {Sphere: {}}, move: [{rotate: {axis: [0, 0, 0], degrees: 3}}]}"),
        2,
        "axis must not be zero",
    ),
    broken(
        "singular matrix",
        body("{shape: {Sphere: {}}, move: [{transform: [[1, 0, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}]}"),
        2,
        "transform: matrix must be invertible",
    ),
    broken(
        "projective matrix",
        body("{shape: {Sphere: {}}, move: [{transform: [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 1, 1]]}]}"),
        2,
        "transform: matrix must be affine",
    ),
    broken(
        "overflowing motion",
        body("{shape: {Sphere: {}}, move: [{scale: 1e100}, {scale: 1e100}, {scale: 1e100}, {scale: 1e100}]}"),
        2,
        "motion must have entries of magnitude up to 1e+100",
    ),
    broken(
        "too many steps",
        body("{shape: {Sphere: {}}, move: [" + "{scale: 2}, " * 1001 + "]}"),
        2,
        "at most 1000 steps, got 1001",
    ),
    # Bulk spheres and files beside the scene ----------------------------------------------------------
    broken(
        "balls without radii", body("shape: {Spheres: {centers: [[0, 0, 0]]}}"), 2, "either centers and radii, or file"
    ),
    broken(
        "balls and a file",
        body("shape: {Spheres: {centers: [], radii: [], file: a.npy}}"),
        2,
        "either centers and radii, or file",
    ),
    broken(
        "more balls than radii",
        body("shape: {Spheres: {centers: [[0, 0, 0], [1, 1, 1]], radii: [1]}}"),
        2,
        "Spheres: radii must have shape (2,)",
    ),
    broken(
        "a ball of radius 0",
        body("shape: {Spheres: {centers: [[0, 0, 0], [1, 1, 1]], radii: [1,\n 0]}}"),
        3,
        "radii[1] must be > 0",
    ),
    broken("missing file", body("shape: {Spheres: {file: none.npy}}"), 2, "is not an existing file", "none.npy"),
    broken("absolute path", body("shape: {Spheres: {file: /etc/passwd}}"), 2, "must be a relative path", "/etc/passwd"),
    broken(
        "path that leaves", body("shape: {Spheres: {file: ../../etc/passwd}}"), 2, "must stay inside the scene's folder"
    ),
    broken("backslashes", body(r"shape: {Spheres: {file: data\balls.npy}}"), 2, "relative path with forward slashes"),
    broken("drive letter", body("shape: {Spheres: {file: 'C:/balls.npy'}}"), 2, "must be a relative path"),
    broken("file is a number", body("shape: {Spheres: {file: 7}}"), 2, "file: must be a text, got 7"),
]
