"""Arguments that do not fit: one table of calls, errors and parts of their messages."""

import numpy as np
import pytest

import conicoid as co

from .test_calls import BALL, BOX, CAMERA, HITS, IMAGE, LEAD_RAYS, LEAD_SCENE, PIXELS, RAYS, SCENE, WITHIN, Table

NO_PART = r"^\w+: z_range must leave a part of the solid"
NO_TRUTH = r"is neither true nor false: shapes combine with & \| - ~, not with `and`"
NO_BODY = "^Body: numbers and names are no bodies: compare hits.name == body.name"
FAR = co.Box((5, -0.1, -1), (6, 0.1, 1))
QUERIES = ("first_hit", "occluded", "spans", "crossings", "lengths", "line_integral")
WHOLE = r"must be an integer|must be a whole number"
THREADS = "set_threads: count must be an integer from 1 to 65536 or None"
NO_WHOLE_NUMBERS = (2.5, True, "2", None, np.array([2, 2]), float("inf"), 1e400, float("nan"), 2 + 0j)
REFUSED = [
    # errors begin with the name of the query
    *(
        (
            lambda query=query, rest=rest: getattr(SCENE, query)(*[[1, 1]] * (query == "line_integral"), *rest),
            TypeError,
            f"^{query}: ",
        )
        for query in QUERIES
        for rest in (((0, 0, 1),), (RAYS, (0, 0, 1)), (SCENE,))
    ),
    # counts are whole numbers
    *(
        (lambda call=call, other=other: call(other), ValueError, message)
        for other in NO_WHOLE_NUMBERS
        for call, message in (
            (lambda count: co.check(co.Sphere(), rays=count), WHOLE),
            (lambda width: co.Scene(co.Sphere()).render(width, 2), WHOLE),
            (lambda seed: co.Scene(co.Sphere()).render(2, 2, seed=seed), WHOLE),
            *[(co.set_threads, THREADS)] * (other is not None),
        )
    ),
    # ends of intervals are no truth values
    *(
        (
            lambda query=query, end=end, value=value: getattr(SCENE, query)(RAYS, **{end: value}),
            ValueError,
            f"{end} must be a number .*, which is true or false$",
        )
        for query in QUERIES[:-1]
        for end in ("t_min", "t_max")
        for value in (True, np.True_, np.array([True, False]))
    ),
    # a box must hold a part
    *(
        (lambda make=make, box=box: make(box), ValueError, r"^\w+: within must hold a part of the solid")
        for make in WITHIN
        for box in (FAR, FAR.rotate("y", 90).rotate("y", -90), FAR.rotate("x", 10))
    ),
    # columns of tables
    *(
        (
            lambda call=call, columns=columns: call(Table([(1.0, 0, 0), (0, 2, 0)], columns)),
            ValueError,
            r"must have columns in the order x, y, z, got \['.*; table\[\['",
        )
        for columns in (["z", "y", "x"], ["y_mm", "x_mm", "z_mm"], ["vz", "vx", "vy"])
        for call in (
            lambda table: co.Rays(table, (0, 0, 1)),
            SCENE.contains,
            lambda table: SCENE.first_hit((0, 0, 9), table),
            lambda table: co.reflect(table, (0, 0, 1)),
        )
    ),
    # rows of spans
    (
        lambda: co.Scene(BALL).spans(RAYS)[1, 2],
        IndexError,
        r"^Spans: index must be a number, .* over the 2 rays, got \(1, 2\)$",
    ),
    (lambda: SCENE.spans(RAYS)[np.zeros(1, bool)], IndexError, "a mask over the"),
    (lambda: SCENE.replace("ball", co.mirror()), TypeError, "replace: item must be a shape or a Body, got Material$"),
    # ellipsoid: radii beside coefficients
    *(
        (
            lambda radii=radii: co.Ellipsoid(radii=radii, coefficients=(1, 1, 1)),
            ValueError,
            "radii must be left out where coefficients are given",
        )
        for radii in ((1, 2, 3), np.array([1.0, 2.0, 3.0]))
    ),
    # one corner is no box
    *(
        (
            lambda corner=corner: co.Box(corner),
            TypeError,
            r"^Box: a box is given by two corners, Box\(low, high\), got .* Box\(\(-x/2, ",
        )
        for corner in ((0.5, 0.5, 0.5), (-1, -1, -1), np.ones(3))
    ),
    # shapes have no truth value
    (lambda: BALL and BOX, TypeError, NO_TRUTH),
    (lambda: (BALL - BOX) or BOX, TypeError, NO_TRUTH),
    (lambda: not co.Disc((0, 0, 0), (0, 0, 1), 1), TypeError, NO_TRUTH),
    (lambda: bool(~BOX), TypeError, NO_TRUTH),
    # a range that leaves nothing
    (lambda: co.Ellipsoid((1, 1, 1), z_range=(2, 3)), ValueError, NO_PART),
    (lambda: co.Ellipsoid((1, 2, 3), z_range=(3, 4)), ValueError, NO_PART),
    (lambda: co.Ellipsoid((1, 2, 3), (0, 0, 9), z_range=(-np.inf, -3)), ValueError, NO_PART),
    (lambda: co.Ellipsoid.from_coefficients(1, 1, 4, z_range=(0.5, 1)), ValueError, NO_PART),
    (lambda: co.EllipticParaboloid(1, 1, (-3, -2)), ValueError, NO_PART),
    (lambda: co.EllipticParaboloid(1, 1, (-np.inf, 0)), ValueError, NO_PART),
    (lambda: co.TwoSheetHyperboloid(1, 1, 1, (-0.5, 0.5)), ValueError, NO_PART),
    (lambda: co.TwoSheetHyperboloid(1, 1, 4, (-0.5, 0.5)), ValueError, NO_PART),
    # bodies are not compared with numbers and names
    (lambda: HITS.body == SCENE["ball"], TypeError, NO_BODY),
    (lambda: SCENE["ball"] == HITS.body, TypeError, NO_BODY),
    (lambda: HITS.name == SCENE["ball"], TypeError, NO_BODY),
    (lambda: HITS.body[0] == SCENE["ball"], TypeError, NO_BODY),
    (lambda: HITS.body != SCENE["ball"], TypeError, NO_BODY),
    # the order of arguments; modules are called
    (
        lambda: SCENE.line_integral(RAYS, [1, 2]),
        TypeError,
        "^line_integral: values come before the rays, got Rays first$",
    ),
    # errors of queries show the value
    (lambda: SCENE.first_hit(HITS), TypeError, "^first_hit: origins must be a Rays, or an array .*, got Hits alone$"),
    (lambda: SCENE.contains((0, 0, np.nan)), ValueError, "^contains: points must be finite"),
    (lambda: SCENE.first_hit(), TypeError, r"^Scene\.first_hit\(\) missing"),
    # items cannot be set
    (lambda: SCENE + co.Sphere(), TypeError, r"scene\.added\(items\)"),
    # unknown properties
    *(
        (
            lambda scene=scene: scene.line_integral("mu", LEAD_RAYS, otherwise=0),
            ValueError,
            "no material has a property 'mu'; properties: ",
        )
        for scene in (co.Scene([BALL]), co.Scene([co.Body(BALL, "red")]), LEAD_SCENE)
    ),
    (
        lambda: LEAD_SCENE.spans(LEAD_RAYS).line_integral("mu", otherwise=0),
        ValueError,
        "no material has a property 'mu'; properties: ",
    ),
    # a colour map is for numbers
    *(
        (
            lambda options=options: co.Image(np.full((2, 2, 3), 0.5), **options),
            ValueError,
            r"Image: \w+ goes with a number per pixel, got colours, \(2, 2, 3\)",
        )
        for options in (dict(vmin=0), dict(vmax=1), dict(colormap="dusk"), dict(colormap="grey"))
    ),
    # box distinguishes a number from three
    (lambda: co.Box(low=2, high=(3, 3, 3)), ValueError, "low must be 3 numbers, got the number 2$"),
    # scene items refused
    (
        lambda: co.Scene(BALL, BOX),
        TypeError,
        "^Scene: lights must be a list of .*, got Box$",
    ),
    (
        lambda: co.Scene([(BALL, "red")]),
        TypeError,
        r"items\[0\] must be a shape or a Body, got tuple$",
    ),
    # values refused
    (lambda: co.Polyhedron([(0, 0, 1)], [1, 2]), ValueError, "Polyhedron: offsets must be a list of 1 number, got 2:"),
    (
        lambda: co.Polyhedron([(0, 0, 1)], 2),
        ValueError,
        "Polyhedron: offsets must be a list of 1 number, got the number 2$",
    ),
    (
        lambda: BALL.rotate("w", 30),
        ValueError,
        "rotate: axis must be 3 numbers, or 'x', 'y', 'z', '-x', '-y', '-z', got 'w'$",
    ),
    *(
        (lambda name=name: BALL.rotate(name, 30), ValueError, "rotate: axis must be 3 numbers")
        for name in ("xy", "--x", "", "-")
    ),
    (lambda: BALL.scale("2"), ValueError, "scale: factors must be one number or 3 numbers, got '2'$"),
    (
        lambda: co.refract(np.ones((4, 3)), np.ones((4, 3)), np.ones(3)),
        ValueError,
        (
            r"refract: eta must be a number or broadcast to the "
            r"rays' shape \(4,\), got shape \(3,\)$"
        ),
    ),
    (
        lambda: co.refract(np.ones((4, 3)), np.ones((5, 3)), 1.5),
        ValueError,
        r"refract: directions and normals must .* \(4, 3\) and \(5, 3\)$",
    ),
    (lambda: SCENE.spans(RAYS, t_min="a"), ValueError, "^spans: t_min must be a number"),
    (lambda: SCENE.crossings(RAYS, t_max=np.nan), ValueError, "^crossings: t_max must not be NaN"),
    (lambda: SCENE.lengths(RAYS, t_max=[1, 2, 3]), ValueError, "^lengths: t_max must be a number or broadcast"),
    (
        lambda: SCENE.line_integral([1, 1], RAYS, t_max=[1, 2, 3]),
        ValueError,
        "^line_integral: t_max must be a number or broadcast",
    ),
    (lambda: SCENE.render(2, 2, integrator="whited"), ValueError, r"got 'whited' \(did you mean 'whitted'\?\)$"),
    (lambda: SCENE.lengths(RAYS, by="materials"), ValueError, r"got 'materials' \(did you mean 'material'\?\)$"),
    (lambda: co.Image(np.eye(2), colormap="grayy"), ValueError, r"got 'grayy' \(did you mean 'grey'\?\)$"),
    (
        lambda: co.Body(BALL, "#3366c"),
        ValueError,
        "must be three linear numbers, '#rrggbb' or a CSS colour name, got '#3366c'$",
    ),
    (lambda: co.matte("bleu"), ValueError, r"got 'bleu' \(did you mean 'blue'\?\)$"),
    # scene index refused
    (lambda: SCENE.replace(7, co.Box()), IndexError, "replace: which number must be at least 0 and below 2, got 7$"),
    # things of another kind refused
    (lambda: SCENE.lengths(RAYS, "material"), TypeError, "^lengths: directions must be left out .*, got str$"),
    (lambda: co.check([BALL]), TypeError, "^check: scene must be a Scene, a shape or a Body, got list$"),
    (lambda: co.ct.project(SCENE, [0, 1], "mu"), TypeError, r"co\.ct\.parallel\(angles, columns\)"),
    # rays name the bad ray
    (lambda: co.Rays((0, 0, 5), (0, 0, np.nan)), ValueError, r"got \(0\.0, 0\.0, nan\)$"),
    (lambda: co.Rays((0, 0, 5), [(0, 0, 1), (0, 0, np.nan)]), ValueError, r"got \(0\.0, 0\.0, nan\) for ray\[1\]$"),
    # section refuses an equation
    (lambda: SCENE.section("z=0"), ValueError, "plane must be 'x', 'y', 'z' or .*, got 'z=0'$"),
    # pictures streams and options refused
    (lambda: LEAD_SCENE.replace("ball"), TypeError, "^replace: item must be a shape or a Body, got None$"),
    (lambda: LEAD_SCENE.rays(-1, 48), ValueError, "^rays: width must be a whole number of pixels >= 1, got -1"),
    (lambda: CAMERA.rays(3, 0), ValueError, "^rays: height must be"),
    (lambda: CAMERA.project((0, 0, 0), 0, 1), ValueError, "^project: width must be"),
    (lambda: LEAD_SCENE.render(0, 4), ValueError, "^render: width must be"),
    (lambda: LEAD_SCENE.section("z", 0, width=0), ValueError, "^section: width must be"),
    (lambda: co.turntable(LEAD_SCENE, "x.gif", width=0), ValueError, "^turntable: width must be"),
    (lambda: co.Rays.from_camera(CAMERA, 0, 1), ValueError, "^rays: width must be"),
    (lambda: IMAGE.layers["body"], KeyError, r"rendered without 'body': scene.render\(layers=\['body'\]\) has it"),
    (lambda: IMAGE.layers["color"], KeyError, "no layer is called 'color': those are albedo, normal, depth"),
    (lambda: co.Image(PIXELS).layers["depth"], KeyError, "rendered without 'depth'"),
    (lambda: IMAGE * 2, TypeError, r"Image: pictures are no numbers: co.Image\(2 \* image.pixels\)"),
    (lambda: 0.5 * IMAGE, TypeError, "Image: pictures are no numbers"),
    (lambda: IMAGE - IMAGE, TypeError, "Image: pictures are no numbers"),
    (
        lambda: co.Spheres([(0, 0, 0)], [1]).single(3),
        IndexError,
        "Spheres.single: index must be at least 0 and below 1, got 3",
    ),
    (
        lambda: co.Boxes([(0, 0, 0)], [(1, 1, 1)]).single(-1),
        IndexError,
        "Boxes.single: index must be at least 0 and below 1",
    ),
    (
        lambda: co.Spheres([(0, 0, 0)], [1]).single("a"),
        TypeError,
        "Spheres.single: index must be a whole number, got 'a'",
    ),
    (
        lambda: next(LEAD_SCENE.stream(LEAD_RAYS, "line_integral", values="mu")),
        ValueError,
        "^line_integral: values: no property 'mu'",
    ),
    (lambda: LEAD_SCENE.stream(*LEAD_RAYS), ValueError, "^stream: query must be one of first_hit, .*, got array"),
    (lambda: next(LEAD_SCENE.stream(CAMERA)), TypeError, "^stream: rays must be Rays, arrays or .*, got Camera$"),
    (
        lambda: LEAD_SCENE.render(8, 6, progress=lambda done: None),
        TypeError,
        r"^render: progress must be called as progress\(done, count\); got the function <lambda>, which",
    ),
    (
        lambda: LEAD_SCENE.render(8, 6, preview=lambda image, more: None),
        TypeError,
        r"must be called as preview\(image\)",
    ),
    (lambda: co.measure(BALL - co.Box(), progress=lambda: None), TypeError, r"^measure: progress must be called as"),
    (
        lambda: LEAD_SCENE.render(8, 6, camera="front"),
        TypeError,
        "camera must be a Camera, OrthographicCamera, EquirectangularCamera, FisheyeCamera or None",
    ),
    (lambda: co.Scene([BALL], background=3), TypeError, "background must be a colour, a Sky, an Environment or None"),
    (lambda: co.Quadric({"xx": 1}), ValueError, r"Quadric\(coefficients=\{...\}\) takes it"),
    # view height refused
    (lambda: co.Scene(co.Sphere()).view(height="big"), ValueError, "view: height must be an integer >= 1, got 'big'"),
    # numbers refused
    (lambda: co.ct.cone([0], 2, 2, 9, 9, spacing=(1, 2, 3)), ValueError, "^cone: spacing must be 2 numbers"),
    (
        lambda: co.ct.parallel([0, np.nan], 3),
        ValueError,
        r"^parallel: angles must be finite numbers of shape \(views,\), got nan$",
    ),
    (
        lambda: SCENE.line_integral({"ball": 1}, RAYS),
        ValueError,
        "no material is called 'ball'; materials: 'steel'$",
    ),
    (lambda: co.Plane("z", 1), ValueError, r"got 'z'; that axis is \(0, 0, 1\)$"),
    (lambda: co.HalfSpace("-Y", 1), ValueError, r"that axis is \(0, -1, 0\)$"),
    (lambda: RAYS.save("rays.npy"), ValueError, r"np\.save\(path, np\.concatenate"),
    (lambda: RAYS.save("rays.csv"), ValueError, r"np\.savetxt\(path"),
    # cauchy coefficients are a list
    (
        lambda: co.optics.Cauchy(1.5),
        ValueError,
        r"^Cauchy: coefficients must be a list of one number or more, got 1.5$",
    ),
]


@pytest.mark.parametrize(("call", "error", "message"), REFUSED)
def test_invalid_arguments_are_refused(call, error, message):
    with pytest.raises(error, match=message):
        call()
