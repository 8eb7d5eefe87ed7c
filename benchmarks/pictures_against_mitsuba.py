"""Pictures of light transport beside those of Mitsuba 3: means, root mean squares of differences, and their pictures.

    python benchmarks/pictures_against_mitsuba.py [SCENE ...] [--size 128] [--samples 256] [--out out/against]
        [--python PYTHON] [--variant llvm_ad_rgb]

Mitsuba runs in a process of its own, by PYTHON, which has it installed; its LLVM variants need DRJIT_LIBLLVM_PATH.
For each scene it prints the mean of both pictures and the difference in percent, with the standard error that the noise
of the difference leaves it, the root mean square of the difference, and the part of that which neighbouring pixels
share, with its standard error: about 0 for noise, but where a few pixels carry most of it that says little, and the
error is large. Both pictures and the difference are written.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
WHITE = [1.0, 1.0, 1.0]
Peer = dict[str, Any]


class Case(NamedTuple):
    """A scene in the words of both, and how often light is scattered at most."""

    ours: Callable[[], dict[str, Any]]
    peer: Peer
    eye: tuple[list[float], list[float], float]
    depth: int = 8


def main() -> None:
    """Render the chosen pictures."""
    if len(sys.argv) > 1 and sys.argv[1] == "--worker":
        worker(json.loads(Path(sys.argv[2]).read_text(encoding="utf-8")), Path(sys.argv[3]))
        return
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("scenes", nargs="*")
    parser.add_argument("--size", type=int, default=128)
    parser.add_argument("--samples", type=int, default=256)
    parser.add_argument("--out", type=Path, default=ROOT / "out" / "against")
    parser.add_argument("--python", default=sys.executable)
    parser.add_argument("--variant", default="llvm_ad_rgb")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    sys.path.insert(0, str(ROOT))
    every = cases()
    print("| scene | mean | Mitsuba | difference | standard error | RMS of difference | shared by neighbours |")
    print("|---|---|---|---|---|---|---|")
    for name in options.scenes or every:
        print(compared(name, every[name], options), flush=True)


def compared(name: str, case: Case, options: argparse.Namespace) -> str:
    """A row of the table."""
    import conicoid as co

    position, target, angle = case.eye
    camera = co.Camera(position, target, field_of_view=angle)
    given = case.ours()
    scene = co.Scene(given["bodies"], lights=given.get("lights", []), background=given.get("background", (0, 0, 0)))
    size, samples = options.size, options.samples
    ours = scene.render(size, size, samples, "path", depth=case.depth, camera=camera).pixels.astype(float)
    with tempfile.TemporaryDirectory() as folder:
        task, result = Path(folder) / "task.json", Path(folder) / "picture.npy"
        settings = dict(size=size, samples=samples, depth=case.depth, eye=case.eye, variant=options.variant)
        task.write_text(json.dumps(dict(scene=case.peer, **settings)), encoding="utf-8")
        subprocess.run([options.python, __file__, "--worker", str(task), str(result)], check=True)
        theirs = np.load(result).astype(float)
    for label, picture in (("ours", ours), ("mitsuba", theirs), ("difference", 0.5 + 2 * (ours - theirs))):
        co.Image(np.clip(picture, 0, None).astype(np.float32)).save(str(options.out / f"{name}-{label}.png"))
    difference = (ours - theirs).mean(axis=2)
    pairs, own = difference[:, 1:] * difference[:, :-1], max((difference**2).sum(), 1e-300)
    shared, doubt = pairs.sum() / own, np.sqrt((pairs**2).sum()) / own
    error = difference.std() / difference.size**0.5 / theirs.mean()
    return (
        f"| {name} | {ours.mean():.5f} | {theirs.mean():.5f} | {100 * (ours.mean() / theirs.mean() - 1):+.3f} % "
        f"| {100 * error:.3f} % | {np.sqrt((difference**2).mean()):.5f} | {shared:+.3f} ± {doubt:.3f} |"
    )


# ---- Mitsuba's side: knows nothing of ours ----


def worker(task: dict[str, Any], out: Path) -> None:
    """Render one scene by Mitsuba."""
    import mitsuba as mi  # type: ignore[import-not-found]

    mi.set_variant(task["variant"])
    transform = mi.ScalarTransform4f
    position, target, angle = task["eye"]
    size = task["size"]
    scene = {name: _made(mi, value) for name, value in task["scene"].items()}
    scene |= {
        "type": "scene",
        "integrator": {"type": "volpath" if task["scene"].get("fog") else "path", "max_depth": task["depth"] + 1},
        "sensor": {
            "type": "perspective", "fov": angle, "fov_axis": "y",
            "to_world": transform().look_at(position, target, [0, 0, 1]),
            "film": {"type": "hdrfilm", "width": size, "height": size, "rfilter": {"type": "box"}},
            "sampler": {"type": "independent", "sample_count": task["samples"]},
        },
    }  # fmt: skip
    made = mi.load_dict(scene)
    left, total, k = task["samples"], 0, 0
    while left > 0:
        some = min(left, 256)
        total, left, k = total + some * np.array(mi.render(made, spp=some, seed=k)), left - some, k + 1
    np.save(out, total / task["samples"])


def _made(mi: Any, value: Any) -> Any:
    """Transforms and images out of lists."""
    if not isinstance(value, dict):
        return value
    if "matrix" in value:
        return mi.ScalarTransform4f(np.array(value["matrix"], float))
    if "image" in value:
        return mi.Bitmap(np.array(value["image"], np.float32))
    return {name: _made(mi, one) for name, one in value.items()}


def rgb(value: list[float] | tuple[float, ...]) -> Peer:
    """A colour."""
    return {"type": "rgb", "value": list(value)}


def matte(color: list[float]) -> Peer:
    """Lambert's law, on both sides."""
    return {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": rgb(color)}}


def ball(center: list[float], radius: float, **more: Any) -> Peer:
    """A ball with a bsdf or an emitter."""
    return {"type": "sphere", "center": center, "radius": radius, **more}


def lamp(radiance: list[float]) -> Peer:
    """What shines."""
    return {"type": "area", "radiance": rgb(radiance)}


def ground(bsdf: Peer, half: float = 40.0) -> Peer:
    """The plane z = 0, as a square."""
    matrix = [[half, 0, 0, 0], [0, half, 0, 0], [0, 0, half, 0], [0, 0, 0, 1]]
    return {"type": "rectangle", "to_world": {"matrix": matrix}, "bsdf": bsdf}


def ceiling_disc(z: float, radius: float, radiance: list[float]) -> Peer:
    """A disc that shines downwards."""
    matrix = [[radius, 0, 0, 0], [0, -radius, 0, 0], [0, 0, -radius, z], [0, 0, 0, 1]]
    return {"type": "disk", "to_world": {"matrix": matrix}, "emitter": lamp(radiance)}


def sky(value: float) -> Peer:
    """Even surroundings."""
    return {"type": "constant", "radiance": rgb([value] * 3)}


# ---- The scenes ----

GREY, RED = [0.7, 0.7, 0.7], [0.7, 0.2, 0.1]
SIDE = ([0.0, -9.0, 4.0], [0.0, 0.0, 1.0], 40.0)
GOLD = dict(index=[0.21, 0.43, 1.31], extinction=[3.272, 2.455, 1.849])


def _floor() -> Any:
    """The body of the ground."""
    import conicoid as co

    square = [(-40, -40, 0), (40, -40, 0), (40, 40, 0), (-40, 40, 0)]
    return co.Body(co.Polygon(square), co.matte(GREY))


def _over(*bodies: Any, light: float = 20.0, background: float = 0.0) -> Callable[[], dict[str, Any]]:
    """Bodies on the ground under a lamp."""
    import conicoid as co

    disc = co.Body(co.Disc((0, 0, 6), (0, 0, -1), 1.0), co.glow([light] * 3))
    return lambda: dict(bodies=[_floor(), disc, *bodies], background=(background,) * 3)


def _under(background: float = 0.0, light: float = 20.0, **shapes: Peer) -> Peer:
    """The same for Mitsuba."""
    around = {"sky": sky(background)} if background else {}
    return {"floor": ground(matte(GREY)), "lamp": ceiling_disc(6, 1.0, [light] * 3), **around, **shapes}


def _on_floor(material: Any) -> Any:
    """A ball on the ground."""
    import conicoid as co

    return co.Body(co.Sphere(1.2, (0, 0, 1.2)), material)


def _same(bsdf: Peer) -> Peer:
    """The same for Mitsuba."""
    return ball([0, 0, 1.2], 1.2, bsdf=bsdf)


def cases() -> dict[str, Case]:
    """All scenes by name."""
    return {"balls": balls(), **_light_cases(), **_material_cases()}


def _light_cases() -> dict[str, Case]:
    """Scenes of one kind of light each."""
    import conicoid as co

    walls = room()
    return {
        "ball-lamp": Case(
            lambda: dict(bodies=[_floor(), co.Body(co.Sphere(0.7, (1, 0, 3)), co.glow(8)), _on_floor(co.matte(RED))]),
            {"floor": ground(matte(GREY)), "lamp": ball([1, 0, 3], 0.7, emitter=lamp([8.0] * 3)),
             "ball": _same(matte(RED))}, SIDE,
        ),
        "point": Case(
            lambda: dict(
                bodies=[_floor(), _on_floor(co.matte(RED))],
                lights=[co.PointLight((3, -3, 5), 30, falloff="inverse_square"), co.DirectionalLight((1, 1, -2), 0.5)],
            ),
            {"floor": ground(matte(GREY)), "ball": _same(matte(RED)),
             "light": {"type": "point", "position": [3.0, -3.0, 5.0], "intensity": rgb([30 * np.pi] * 3)},
             "sun": {"type": "directional", "direction": [1.0, 1.0, -2.0], "irradiance": rgb([0.5 * np.pi] * 3)}},
            SIDE,
        ),
        "surroundings": Case(
            lambda: dict(bodies=[_floor(), _on_floor(co.matte(RED))], background=co.Environment(seen_image(64, 128))),
            {"floor": ground(matte(GREY)), "ball": _same(matte(RED)),
             "sky": {"type": "envmap", "bitmap": {"image": peer_image(64, 128)},
                     "to_world": {"matrix": [[0, 0, -1, 0], [-1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]]}}},
            SIDE,
        ),
        "room": Case(lambda: dict(bodies=walls[0]), walls[1], ([0.0, -0.99, 0.0], [0.0, 1.0, 0.0], 80.0), 12),
    }  # fmt: skip


def _material_cases() -> dict[str, Case]:
    """Scenes of one material each, and of lamps that are cylinders."""
    import conicoid as co

    rough = {"type": "roughconductor", "alpha": 0.3, "distribution": "ggx"}
    metal = {"eta": rgb(GOLD["index"]), "k": rgb(GOLD["extinction"])}
    glass = {"int_ior": 1.5, "ext_ior": 1.0}
    smooth_plastic = {"type": "plastic", "diffuse_reflectance": rgb(RED), **glass, "nonlinear": True}
    return {
        "glass": Case(_over(_on_floor(co.glass(1.5))), _under(ball=_same({"type": "dielectric", **glass})), SIDE),
        "rough-glass": Case(
            _over(_on_floor(co.glass(1.5, roughness=0.1))),
            _under(ball=_same({"type": "roughdielectric", "alpha": 0.1, "distribution": "ggx", **glass})), SIDE,
        ),
        "gold": Case(
            _over(_on_floor(co.materials.conductor(**GOLD))), _under(ball=_same({"type": "conductor", **metal})), SIDE
        ),
        "rough-gold": Case(
            _over(_on_floor(co.materials.conductor(**GOLD, roughness=0.1))),
            _under(ball=_same({**rough, **metal, "alpha": 0.1})), SIDE,
        ),
        "plastic": Case(
            _over(_on_floor(co.plastic(RED)), background=0.5), _under(0.5, ball=_same(smooth_plastic)), SIDE
        ),
        "cylinders": Case(
            _over(
                co.Body(co.Cylinder((-2, 0, 0.5), (0, 1, 2), 0.5), co.matte(RED)),
                co.Body(co.Cylinder((1.5, -1, 1.5), (2.5, 0, 2.5), 0.2), co.glow(5)), light=5,
            ),
            _under(
                light=5, a=cylinder([-2, 0, 0.5], [0, 1, 2], 0.5, bsdf=matte(RED)),
                **caps([-2, 0, 0.5], [0, 1, 2], 0.5, "a", bsdf=matte(RED)),
                b=cylinder([1.5, -1, 1.5], [2.5, 0, 2.5], 0.2, emitter=lamp([5.0] * 3)),
                **caps([1.5, -1, 1.5], [2.5, 0, 2.5], 0.2, "b", emitter=lamp([5.0] * 3)),
            ), SIDE,
        ),
        "fog": Case(
            _over(_on_floor(co.fog([1.0, 1.5, 2.0], [0.1, 0.05, 0.0], 0.3)), background=0.2),
            _under(0.2, ball=_same({"type": "null"}) | {"interior": {
                "type": "homogeneous", "scale": 2.0, "sigma_t": rgb([0.55, 0.775, 1.0]),
                "albedo": rgb([1 / 1.1, 1.5 / 1.55, 1.0]),
                "phase": {"type": "hg", "g": 0.3},
            }}) | {"fog": {"type": "null"}}, SIDE, 20,
        ),
    }  # fmt: skip


def balls() -> Case:
    """1,000 matte balls under an even sky."""
    import conicoid as co

    rng = np.random.default_rng(1)
    centers, radii = rng.uniform(-10, 10, (1000, 3)), rng.uniform(0.3, 0.9, 1000)
    peer = {
        f"ball{k}": ball(c.tolist(), float(r), bsdf=matte(GREY))
        for k, (c, r) in enumerate(zip(centers, radii, strict=True))
    }
    return Case(
        lambda: dict(bodies=[co.Body(co.Spheres(centers, radii), co.matte(GREY))], background=(1, 1, 1)),
        {"sky": sky(1.0), **peer}, ([0.0, -40.0, 0.0], [0.0, 0.0, 0.0], 35.0), 5,
    )  # fmt: skip


def cylinder(start: list[float], end: list[float], radius: float, **more: Any) -> Peer:
    """The wall of a cylinder."""
    return {"type": "cylinder", "p0": start, "p1": end, "radius": radius, **more}


def caps(start: list[float], end: list[float], radius: float, name: str, **more: Any) -> dict[str, Peer]:
    """The ends of a cylinder."""
    axis = np.subtract(end, start) / np.linalg.norm(np.subtract(end, start))
    found = {}
    for label, center, sign in (("low", start, -1), ("high", end, 1)):
        z = sign * axis
        x = np.cross([0.3, 0.5, 0.8], z)
        x /= np.linalg.norm(x)
        matrix = np.eye(4)
        matrix[:3, :3] = np.stack([radius * x, radius * np.cross(z, x), z], axis=1)
        matrix[:3, 3] = center
        found[name + label] = {"type": "disk", "to_world": {"matrix": matrix.tolist()}, **more}
    return found


def radiance(theta: Any, phi: Any) -> Any:
    """A sky that is smooth: a glow on one side, and colours."""
    x, y, z = np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)
    spot = 20 * np.exp(8 * ((0.5 * x - 0.4 * y + 0.77 * z) - 1))
    return np.stack([0.3 + 0.2 * x + spot, 0.4 + 0.2 * y + 0.9 * spot, 0.5 + 0.3 * z + 0.7 * spot], axis=-1)


def seen_image(height: int, width: int) -> Any:
    """Our image: values in the middles of pixels."""
    theta, phi = (np.arange(height) + 0.5) / height * np.pi, (np.arange(width) + 0.5) / width * 2 * np.pi
    return radiance(*np.meshgrid(theta, phi, indexing="ij"))


def peer_image(height: int, width: int) -> Any:
    """Mitsuba's: the first and the last row are the poles, columns begin at the edge; turned the other way."""
    theta, phi = np.arange(height) / (height - 1) * np.pi, -np.arange(width) / width * 2 * np.pi
    return radiance(*np.meshgrid(theta, phi, indexing="ij")).tolist()


def room() -> tuple[list[Any], Peer]:
    """A cube of side 2 with a red and a green wall, a lamp in its ceiling, and a ball."""
    import conicoid as co

    square = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    bodies, peer = [], {}
    for name, axis, sign, color in (
        ("left", 0, -1, RED), ("right", 0, 1, [0.1, 0.6, 0.2]), ("near", 1, -1, GREY), ("far", 1, 1, GREY),
        ("low", 2, -1, GREY), ("high", 2, 1, GREY),
    ):  # fmt: skip
        corners = np.insert(square.astype(float), axis, sign, axis=1)
        bodies.append(co.Body(co.Polygon(corners.tolist()), co.matte(color)))
        matrix = np.eye(4)
        matrix[:3, 2], matrix[:3, 3] = 0, 0
        matrix[axis, 2], matrix[axis, 3] = -sign, sign
        others = [k for k in range(3) if k != axis]
        matrix[:3, :2] = 0
        matrix[others[0], 0], matrix[others[1], 1] = 1, 1
        if np.linalg.det(matrix) < 0:
            matrix[others[1], 1] = -1
        peer[name] = {"type": "rectangle", "to_world": {"matrix": matrix.tolist()}, "bsdf": matte(color)}
    lamp_corners = [(-0.3, -0.3, 0.98), (0.3, -0.3, 0.98), (0.3, 0.3, 0.98), (-0.3, 0.3, 0.98)]
    bodies += [
        co.Body(co.Polygon(lamp_corners), co.glow(10)),
        co.Body(co.Sphere(0.4, (0.2, 0.3, -0.6)), co.matte(GREY)),
    ]
    flip = [[0.3, 0, 0, 0], [0, -0.3, 0, 0], [0, 0, -0.3, 0.98], [0, 0, 0, 1]]
    back = [[0.3, 0, 0, 0], [0, 0.3, 0, 0], [0, 0, 0.3, 0.9801], [0, 0, 0, 1]]  # ours shines on both sides
    for name, place in (("lamp", flip), ("back", back)):
        shine = dict(emitter=lamp([10.0] * 3), bsdf=matte([0.0] * 3))
        peer[name] = {"type": "rectangle", "to_world": {"matrix": place}, **shine}
    peer["ball"] = ball([0.2, 0.3, -0.6], 0.4, bsdf=matte(GREY))
    return bodies, peer


if __name__ == "__main__":
    main()
