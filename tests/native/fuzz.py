"""Wrong arguments to every kernel of the extension, by its door.

It is a program, because a wrong argument that passes the door ends the process: python -m tests.native.fuzz COUNT
[SEED]. First it works with scenes and keeps some calls of every kernel. Then it makes COUNT calls, each a kept one with
one fault. An error must follow where the declaration of the kernel forbids the fault.
"""

from __future__ import annotations

import ctypes
import functools
import mmap
import random
import sys
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from conicoid._jit import decorators as jit, machine_code
from conicoid._jit.decorators import DECLARED

_protect = getattr(ctypes.CDLL(None), "mprotect", None) if sys.platform != "win32" else None
KEPT = 3  # calls of each kernel
_calls: dict[str, list[tuple[Any, ...]]] = defaultdict(list)
_found = machine_code.SHIPPED.kernel if machine_code.SHIPPED else None


def _before_a_wall(array: Any) -> Any:
    """Return a copy that ends at protected memory: a kernel that goes beyond it ends the process."""
    page = mmap.PAGESIZE
    size = -(-array.nbytes // page) * page
    room = mmap.mmap(-1, size + page)
    if _protect is not None:
        start = ctypes.addressof(ctypes.c_char.from_buffer(room))
        assert _protect(ctypes.c_void_p(start + size), ctypes.c_size_t(page), 0) == 0
    copy = np.frombuffer(room, array.dtype, array.size, size - array.nbytes).reshape(array.shape)
    copy[...] = array
    return copy


def _copied(value: Any) -> Any:
    """Return a copy in memory of its own, because kernels write."""
    if isinstance(value, np.ndarray):
        copy = _before_a_wall(value)
        copy.flags.writeable = value.flags.writeable
        return copy
    if isinstance(value, tuple):
        parts = [_copied(part) for part in value]
        return type(value)(*parts) if hasattr(value, "_fields") else tuple(parts)
    return value


def _recording(name: str) -> Callable[..., Any] | None:
    """Return a kernel that keeps its arguments, in place of `machine_code.entry`."""
    kernel = _found(name)
    if kernel is None:
        return None

    def call(*arguments: Any) -> Any:
        if len(_calls[name]) < KEPT:
            _calls[name].append(_copied(arguments))
        result = kernel(*arguments)
        return np.asarray(result) if machine_code.SHIPPED.returns_array(name) else result

    return call


def work() -> None:
    """Call every kernel."""
    import conicoid as co
    from conicoid.prepare.bvh.sah_binning import ONE_THREAD
    from conicoid.scene.warmup import CutCylinders

    rng = np.random.default_rng(0)
    scene = co.Scene(
        [
            co.Sphere(1.0) & co.Box((-1, -1, -1), (1, 1, 0.5)), co.Spheres(rng.uniform(2, 9, (ONE_THREAD + 9, 3)), 0.01),
            co.Polygon([(5, 0, 0), (6, 0, 0), (5, 1, 0)]), co.Body(co.Cylinder((0, 3, 0), (0, 4, 1), 0.5), co.glass()),
            co.Sphere(1.0, (0, 0, 1)) - co.Sphere(0.5), co.Plane((0, 0, 1), -9), co.Sphere(1.0, (-3, 0, 0)),
            co.Sphere(1.0, (-4, 0, 0)),
        ],
        lights=[co.PointLight((5, 5, 5)), co.AmbientLight(0.2)],
    )  # fmt: skip
    for origins, directions in (
        (rng.uniform(-3, 3, (3000, 3)), rng.normal(size=(3000, 3))), ([[1.0, 0.0, 5.0]] * 70, (0.0, 0.0, -1.0)),
        ([(-3.5, 0.0, 5.0), (0, 0, 9)], (0.0, 0.0, -1.0)),
    ):  # fmt: skip
        hits = scene.first_hit(origins, directions)
        for rays in (hits.rays, hits.spawn(rng.normal(size=hits.point.shape))):
            scene.occluded(rays)
            for answer in (scene.first_hit(rays), scene.spans(rays), scene.crossings(rays)):
                answer.detached()
            scene.line_integral(np.ones(scene._prepared.lowered.body_count), rays)
            scene.spans(rays).lengths("material")
        many = [np.tile(np.asarray(part, np.float64), (20_000, 1))[:20_000] for part in (origins, directions)]
        co.Rays(*many), co.Rays(*(part.astype("f4") for part in many))
        co.Rays(*map(_frozen, many))
        scene.first_hit(*(np.ones((20_000, 3)) for _ in range(2)))  # coherent rays, copied as they are traced
        hits.uv, hits.local_point, hits.point_error  # noqa: B018
        _moved(scene, hits)
    edge = (-3.5, 0.5, 5.0), (0.0, 0.0, -1.0)
    two = co.Scene([co.Sphere(1.0), co.Sphere(1.0, (1.0, 0.0, 0.0))])
    for query in (two.first_hit, two.spans, two.crossings):
        query((0.5, 0.0, 5.0), edge[1]).detached()
    co.Scene([co.Quadric(coefficients=dict(xx=1, xy=1, yy=1, zz=1, constant=-3))]).contains((1.0, 1.0, 0.0))
    endless = [*(co.HalfSpace((1, 2, k), 1.0) for k in range(3)), co.Quadric(coefficients={"xx": 1})]
    co.Scene([co.Intersection(tuple(endless))]).prepare()
    scene.contains(rng.uniform(-3, 3, (100, 3)))
    scene.bodies_at(rng.uniform(-3, 3, (100, 3)))
    for fractions in (None, "body"):
        scene.voxels(((-1, -1, -1), (1, 1, 1)), 3, fractions=fractions, samples=1)
    co.measure(co.Sphere(1.0) - co.Box(), 600)
    co.check(co.Scene([co.Sphere(1.0), co.Sphere(1.0, (1.0, 0.0, 0.0))]), 300)
    for exact in (False, True):
        scene.distance(rng.uniform(-3, 3, (100, 3)), exact=exact).detached()
    for integrator in ("whitted", "normals", "path", "occlusion", "albedo"):
        scene.render(24, 16, samples=1, integrator=integrator, layers="samples")
    co.FisheyeCamera((0, 0, 9), (0, 0, 0)).rays(5, 4)
    co.Rays.from_scan(co.ct.cone([0, 30], 3, 4, 30, 10)).to_rays()
    co.Scene([co.Sphere(1.0, (k, 0, 0)).rotate((1, 2, 3), k + 0.5) for k in range(20)]).prepare()
    co.Scene([(co.Cone((0, 0, 0), (0, 0, 1), 1, 0.2) & co.Box()).rotate((1, 2, 3), 30)]).prepare()
    for shift in ((0, 0, 0), (2.0**-120, 0, 0)):  # beside a number halfway between two floats
        co.Scene([co.Sphere(1.0, (1, k, 0)).translate((2.0**-53, 0, 0)).translate(shift) for k in range(9)]).prepare()
    co.Scene([co.Cylinder((0, 0, 0), (1, 2, 3), 0.1 + tiny) for tiny in (0.0, 2.0**-56)]).prepare()
    angles = 2.0 * np.pi * np.arange(34) / 34
    normals = np.stack([np.cos(angles), np.sin(angles), 0.3 * (-1.0) ** np.arange(34)], axis=1)
    solid = co.Polyhedron(normals, np.ones(34))
    co.Scene([solid, solid.rotate((1, 2, 3), 30)]).first_hit((0, 0, -9), (0, 0, 1))
    co.Scene([co.Sphere(1.0)]).first_hit([(0, 0, 1e9)], (0, 0, -1)).point  # noqa: B018
    scene_of_copies = co.Scene(CutCylinders())
    scene_of_copies.prepare()
    scene_of_copies.moved(5, (0, 0, 0.5)).first_hit((0, 0, 9), (0, 0, -1))
    _as_pages_ask(scene)
    for body in (0, "sheet"):
        sheet = co.Body(co.Polygon([(-1, -1, 0), (1, -1, 0), (0, 1, 0)]) & co.Sphere(1.0), name="sheet")
        co.Scene([co.Sphere(1.0) - co.Box(), sheet]).explain((0.1, 0.2, 5.0), (0.0, 0.0, -1.0), body=body)


def _moved(scene: Any, hits: Any) -> None:
    """Find the derivatives of hits and spans by their rays and by one number."""
    import conicoid as co

    parameters = co.parameters(scene, "bodies[0].operands[0].radius")
    for answer in (hits, scene.spans(hits.rays)):
        answer.jvp(parameters, [1.0], d_origins=(0.0, 0.0, 1.0))
    hits.vjp(parameters, t=hits.hit * 1.0)


def _as_pages_ask(scene: Any) -> None:
    """Trace rays one at a time, in memory of its own, as pages do."""
    import conicoid as co
    from conicoid.kernels.crossings import trace_rows_alone
    from conicoid.kernels.first_hits import HitBuffers, trace_first_alone
    from conicoid.queries.hit_fields import hit_alone
    from conicoid.queries.ray_queries import arrays_of

    arrays = arrays_of("fuzz", scene._prepared, co.Rays([(0, 0, 5), (1, 0, 5)], (0, 0, -1)), 0.0, np.inf)
    trace_first_alone(scene._prepared.geometry, arrays, 0, 2, HitBuffers.new(2))
    lines, whole, real = (np.ones((1, 3)),) * 3, np.zeros(1, np.int32), np.ones(1)
    hit_alone(scene._prepared.geometry, *lines, real, *[whole] * 6, *[real] * 6)
    for spans in (True, False):
        trace_rows_alone(scene._prepared.geometry, arrays, spans, 0, 2, np.zeros(2, np.int32), np.zeros(2, np.int8))


# ---- Spoiling ----


def _leaves(value: Any, path: tuple[int, ...] = ()) -> Iterator[tuple[tuple[int, ...], Any]]:
    """Return the parts of arguments that are not tuples, and the tuples, with the way to each."""
    if isinstance(value, tuple):
        for k, part in enumerate(value):
            yield (*path, k), part
            yield from _leaves(part, (*path, k))


def _with(value: Any, path: tuple[int, ...], part: Any) -> Any:
    """Return the arguments with another part."""
    if not path:
        return part
    parts = list(value)
    parts[path[0]] = _with(parts[path[0]], path[1:], part)
    return type(value)(*parts) if hasattr(value, "_fields") else tuple(parts)


def _misaligned(array: Any) -> Any:
    room = np.zeros(array.nbytes + 1, np.uint8)
    other = room[1:].view(array.dtype) if array.nbytes else np.zeros(0, array.dtype)
    other = other.reshape(array.shape)
    other[...] = array
    return other


def _strided(array: Any) -> Any:
    other = np.zeros((*array.shape[:-1], 2 * array.shape[-1]), array.dtype)[..., ::2]
    other[...] = array
    return other


def _resized(array: Any, axis: int, more: int) -> Any:
    """Return an array with more elements, copies of the last, or fewer.

    The others stay, because the door cannot check them.
    """
    size = array.shape[axis]
    if size + more < 0 or size == 0:
        return np.zeros([max(0, n + more * (k == axis)) for k, n in enumerate(array.shape)], array.dtype)
    return np.take(array, np.minimum(np.arange(size + more), size - 1), axis=axis)


def _other_type(array: Any) -> Any:
    with np.errstate(over="ignore"):  # no float32 is as large
        return 1 if array.dtype.names else array.astype("f4" if array.dtype != np.float32 else "f8")


ARRAYS: dict[str, tuple[Callable[[Any], Any], bool]] = {
    "other type": (lambda a: _other_type(a), True),
    "other integer": (lambda a: np.zeros(a.shape, "u2"), True),
    "other order of bytes": (lambda a: a.astype(a.dtype.newbyteorder()) if a.itemsize > 1 else "x", True),
    "one dimension more": (lambda a: a[None], True),
    "a number": (lambda a: a.dtype.type() if a.dtype.names is None else 0, True),
    "a list": (lambda a: a.tolist(), True),
    "None": (lambda a: None, True),
    "bytes": (lambda a: b"12345678", True),
    "strided": (lambda a: _strided(a), False),  # an array with one element is contiguous all the same
    "backwards": (lambda a: a[::-1] if len(a) > 1 else None, True),
    "Fortran's order": (lambda a: np.asfortranarray(a), False),
    "misaligned": (_misaligned, False),
    "shorter by one": (lambda a: _resized(a, 0, -1), False),
    "longer by one": (lambda a: _resized(a, 0, 1), False),
    "empty": (lambda a: a[:0].copy(), False),
    "other columns": (lambda a: _resized(a, -1, 1), False),
    "not to be written": (lambda a: _frozen(a), False),
}
NUMBERS: tuple[Any, ...] = (
    None, "1", 1 << 70, -(1 << 70), -1, -(1 << 62), 1 << 62, 300, 0, 3, 2.5, float("nan"), np.zeros(2), (1,), True, [],
)  # fmt: skip
TUPLES: tuple[Callable[[Any], Any], ...] = (
    lambda t: t[:-1], lambda t: (*t, t[-1]), lambda t: list(t), lambda t: None, lambda t: t[::-1], lambda t: (),
)  # fmt: skip


def _frozen(array: Any) -> Any:
    other = array.copy()
    other.flags.writeable = False
    return other


SHORTER = "shorter by one", "empty"


@functools.cache
def _free_and_strided(name: str) -> tuple[frozenset[int], frozenset[int]]:
    """Return which of a kernel's arrays may have any length, and which may have elements that lie apart.

    Only indices limit the length of the former. The latter may be in any order.
    """
    from native.signature import signature  # imports the engine, whose kernels must be recorded

    arrays = [leaf for leaf in signature(*DECLARED[name]).leaves if leaf.kind == "array"]
    free = frozenset(k for k, leaf in enumerate(arrays) if leaf.lengths[0] is None)
    return free, frozenset(k for k, leaf in enumerate(arrays) if leaf.strided)


def _is_one(which: frozenset[int], arguments: tuple[Any, ...], path: tuple[int, ...]) -> bool:
    arrays = [way for way, part in _leaves(arguments) if isinstance(part, np.ndarray)]
    return arrays.index(path) in which


def spoilt(name: str, arguments: tuple[Any, ...], rng: random.Random) -> tuple[tuple[Any, ...], str, bool]:
    """Return arguments with one change, its name, and whether there must be an error."""
    if rng.random() < 0.02:
        return (arguments[:-1], "one less", True) if rng.random() < 0.5 else ((*arguments, 1), "one more", True)
    path, part = rng.choice(list(_leaves(arguments)))
    if isinstance(part, np.ndarray):
        change = rng.choice(
            [
                change
                for change in ARRAYS
                if change not in SHORTER or not _is_one(_free_and_strided(name)[0], arguments, path)
            ]
        )
        make, must = ARRAYS[change]
        must = must and not (change == "backwards" and _is_one(_free_and_strided(name)[1], arguments, path))
        other = make(part)
        if isinstance(other, np.ndarray) and other.flags.c_contiguous and other.flags.aligned:
            other = _copied(other)
    elif isinstance(part, tuple):
        number = rng.randrange(len(TUPLES))
        change, other, must = f"tuple {number}", TUPLES[number](part), number not in (4,)
    else:
        other = rng.choice(NUMBERS)
        change, must = f"{type(part).__name__} {other!r}"[:40], isinstance(other, str | list | tuple | np.ndarray)
    return _with(arguments, path, other), f"{path} {change}", must


def fuzz(count: int, seed: int) -> Counter[str]:
    """Make wrong calls of all kernels in turn; return how many had each outcome."""
    rng, outcomes = random.Random(seed), Counter[str]()
    names = sorted(_calls)
    for k in range(count):
        name = names[k % len(names)]
        arguments, change, must = spoilt(name, _copied(rng.choice(_calls[name])), rng)
        try:
            _found(name)(*arguments)
            outcome = "went through"
        except (TypeError, ValueError) as error:
            outcome = type(error).__name__
            if not str(error).startswith(name):
                raise AssertionError(f"{name}, {change}: {error}") from None
        if must and outcome == "went through":
            raise AssertionError(f"{name}, {change}: no error")
        outcomes[outcome] += 1
    return outcomes


def main(count: int, seed: int = 0) -> None:
    """Work, then make wrong calls."""
    jit.entry = _recording
    work()
    left = set(machine_code.SHIPPED.kernels()) - _calls.keys()
    assert not left, f"never called: {left}"
    print(dict(fuzz(count, seed)), flush=True)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
