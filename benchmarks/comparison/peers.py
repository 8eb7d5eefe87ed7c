"""Embree 4: nearest hits on spheres and its tree over them, through the library in the wheel `embreex`.

Single precision, one `rtcIntersect1` for each ray. It is called from a compiled loop, on as many threads as
Conicoid uses, so a ray costs what Embree takes and a plain call.
"""

from __future__ import annotations

import ctypes
import functools
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import IO, Any

import numpy as np
from PIL import Image

from conicoid.kernels.threads import run_chunks, thread_count

from .harness import ROOT, Absent, Peer, distribution, module
from .scenes import BallRows, BoxRows, Floats, Singles

SPHERE_POINT, VERTEX_BUFFER, FLOAT4, QUALITY_HIGH = 50, 1, 0x9004, 2  # of Embree's headers
_EMBREE_CHUNK = 16384


def _embree_version() -> str:
    version = distribution("embreex")
    distribution("numba")
    _embree_library()
    return f"Embree 4 (embreex {version})"


EMBREE = Peer("Embree", "rtcIntersect1, float32", _embree_version)


@functools.cache
def _embree_library() -> Any:
    folder = Path(module("embreex", "embreex").__file__).parent
    beside = folder.parent / "embreex.libs"
    places = [*beside.glob("*"), *(folder / ".dylibs").glob("*"), *folder.glob("*.dll")]
    tbb = [path for path in places if path.name.startswith(("libtbb", "tbb"))]
    embree = [path for path in places if path.name.startswith(("libembree4", "embree4"))]
    if not embree:
        raise Absent(f"no Embree library beside {folder}")
    try:
        for path in tbb:
            ctypes.CDLL(str(path), mode=ctypes.RTLD_GLOBAL)
        library = ctypes.CDLL(str(embree[0]))
    except OSError as error:
        raise Absent(f"embreex is installed but its library does not load: {error}") from None
    _declare_embree(library)
    return library


def _declare_embree(library: Any) -> None:
    pointer, number, size = ctypes.c_void_p, ctypes.c_uint, ctypes.c_size_t
    for name, result, arguments in (
        ("rtcNewDevice", pointer, [ctypes.c_char_p]),
        ("rtcNewScene", pointer, [pointer]),
        ("rtcNewGeometry", pointer, [pointer, ctypes.c_int]),
        ("rtcSetNewGeometryBuffer", pointer, [pointer, ctypes.c_int, number, ctypes.c_int, size, size]),
        ("rtcCommitGeometry", None, [pointer]),
        ("rtcAttachGeometry", number, [pointer, pointer]),
        ("rtcSetSceneBuildQuality", None, [pointer, ctypes.c_int]),
        ("rtcCommitScene", None, [pointer]),
        ("rtcReleaseGeometry", None, [pointer]),
        ("rtcReleaseScene", None, [pointer]),
        ("rtcReleaseDevice", None, [pointer]),
        ("rtcIntersect1", None, [pointer, pointer, pointer]),
    ):
        function = getattr(library, name)
        function.restype, function.argtypes = result, arguments


class EmbreeScene:
    """Balls in Embree; use it in a `with` block. `build_seconds` is the time of the commit at high quality."""

    def __init__(self, balls: BallRows) -> None:
        library = self._library = _embree_library()
        self._device = library.rtcNewDevice(f"threads={thread_count()}".encode())
        self._scene = library.rtcNewScene(self._device)
        geometry = library.rtcNewGeometry(self._device, SPHERE_POINT)
        count = len(balls.radii)
        data = library.rtcSetNewGeometryBuffer(geometry, VERTEX_BUFFER, 0, FLOAT4, 16, count)
        if not data:
            raise MemoryError("Embree: no memory for the balls")
        vertices = np.ctypeslib.as_array(ctypes.cast(data, ctypes.POINTER(ctypes.c_float)), (count, 4))
        vertices[:, :3], vertices[:, 3] = balls.centers, balls.radii
        library.rtcCommitGeometry(geometry)
        library.rtcAttachGeometry(self._scene, geometry)
        library.rtcReleaseGeometry(geometry)
        library.rtcSetSceneBuildQuality(self._scene, QUALITY_HIGH)
        begin = time.perf_counter()
        library.rtcCommitScene(self._scene)
        self.build_seconds = time.perf_counter() - begin

    def __enter__(self) -> EmbreeScene:
        return self

    def __exit__(self, *_: object) -> None:
        self._library.rtcReleaseScene(self._scene)
        self._library.rtcReleaseDevice(self._device)

    def first_hits(self, origins: Singles, directions: Singles) -> tuple[float, Floats]:
        """(seconds, t (M,), inf for a miss) of rays (M, 3)."""
        t = np.empty(len(origins), np.float32)
        call, scene, trace = self._library.rtcIntersect1, self._scene, _embree_trace()
        trace(call, scene, origins, directions, t, 0, 0)
        begin = time.perf_counter()
        run_chunks(lambda a, b: trace(call, scene, origins, directions, t, a, b), len(t), _EMBREE_CHUNK)
        return time.perf_counter() - begin, t.astype(float)


@functools.cache
def _embree_trace() -> Any:
    """The loop over rays, compiled."""
    return module("numba", "numba").njit(nogil=True)(_embree_calls)


def _embree_calls(
    call: Any, scene: int, origins: Singles, directions: Singles, t: Singles, first: int, last: int
) -> None:
    """RTCRayHit in words of four bytes: origin 0, tnear 3, direction 4, time 7, tfar 8, mask 9, flags 11, ids 18."""
    raw = np.empty(48, np.float32)
    skip = ((64 - raw.ctypes.data % 64) % 64) // 4
    words = raw[skip : skip + 24]
    bits = words.view(np.int32)
    for i in range(first, last):
        words[0], words[1], words[2] = origins[i, 0], origins[i, 1], origins[i, 2]
        words[4], words[5], words[6] = directions[i, 0], directions[i, 1], directions[i, 2]
        words[3], words[7], words[8] = np.float32(0), np.float32(0), np.float32(np.inf)
        bits[9], bits[11], bits[18], bits[19] = -1, 0, -1, -1
        call(scene, words.ctypes.data, 0)
        t[i] = words[8]


# Mitsuba 3 on its LLVM backend: nearest hits on spheres, single precision, in a process of its own.
#
# Its compiler is a shared LLVM of the system, which must not meet the one that is part of llvmlite.

OLDEST_LLVM = 16
"""The oldest LLVM that Mitsuba's compiler works with on current processors."""

_LLVM_FOLDERS = (
    "/usr/lib/*-linux-gnu", "/usr/lib/llvm-*/lib", "/usr/lib64", "/usr/lib64/llvm*/lib64", "/usr/lib", "/usr/local/lib",
    "/opt/homebrew/opt/llvm/lib", "/usr/local/opt/llvm/lib",
)  # fmt: skip


def _mitsuba_version() -> str:
    version = distribution("mitsuba")
    return f"Mitsuba {version} (llvm_ad_rgb, LLVM {_llvm_version(find_llvm())})"


MITSUBA = Peer("Mitsuba", "LLVM, float32", _mitsuba_version)


def find_llvm() -> Path:
    """A shared LLVM library: DRJIT_LIBLLVM_PATH, or the newest in the usual places; raises Absent without one."""
    chosen = os.environ.get("DRJIT_LIBLLVM_PATH")
    if chosen:
        if not Path(chosen).is_file():
            raise Absent(f"DRJIT_LIBLLVM_PATH names no file: {chosen}")
        return Path(chosen)
    found = [
        path
        for folder in _LLVM_FOLDERS
        for path in Path("/").glob(f"{folder[1:]}/libLLVM*")
        if re.search(r"\.(so|dylib)", path.name) and _llvm_version(path) >= OLDEST_LLVM
    ]
    if not found:
        raise Absent(f"needs LLVM {OLDEST_LLVM} or newer: apt-get install libllvm19, or set DRJIT_LIBLLVM_PATH")
    return max(found, key=lambda path: (_llvm_version(path), path.name))


def _llvm_version(path: Path) -> int:
    """Return 19 for libLLVM.so.19.1 and libLLVM-19.so, 0 where neither the name nor the link's target has a number."""
    for name in (path.name, path.resolve().name):
        numbers = re.search(r"libLLVM(?:-(\d+)|\.so\.(\d+)|\.(\d+)\.dylib)", name)
        if numbers:
            return int(next(filter(None, numbers.groups())))
    return 0


class MitsubaScene:
    """Balls and rays (M, 3) in Mitsuba's process; use it in a `with` block."""

    def __init__(self, balls: BallRows, origins: Singles, directions: Singles, coherent: bool) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="conicoid-bench-")
        folder = Path(self._folder.name)
        np.savez(
            folder / "scene.npz", centers=balls.centers, radii=balls.radii, origins=origins, directions=directions,
            coherent=coherent, threads=thread_count(),
        )  # fmt: skip
        self._complaints = (folder / "complaints.txt").open("w+")
        self._process = subprocess.Popen(
            [sys.executable, "-m", "benchmarks.comparison.mitsuba_worker", str(folder)], cwd=ROOT,
            env={**os.environ, "DRJIT_LIBLLVM_PATH": str(find_llvm())},
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._complaints, text=True,
            start_new_session=True,  # Ctrl-C comes to us, and we end it
        )  # fmt: skip
        try:
            self._answer()
        except BaseException:
            self.__exit__()
            raise

    def __enter__(self) -> MitsubaScene:
        return self

    def __exit__(self, *_: object) -> None:
        self._process.kill()
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout, self._complaints):
            _close_pipe(pipe)
        self._folder.cleanup()

    def seconds(self) -> float:
        """Return the time of one run of all rays."""
        assert self._process.stdin is not None
        try:
            self._process.stdin.write("run\n")
            self._process.stdin.flush()
        except BrokenPipeError:
            pass  # _answer has the reason
        return float(self._answer())

    def distances(self) -> Floats:
        """Return t (M,) of the last run, inf for a miss."""
        single: Singles = np.load(Path(self._folder.name) / "t.npy")
        return single.astype(float)

    def _answer(self) -> str:
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if line.startswith("answer "):
            return line.split()[1]
        self._complaints.seek(0)
        lines = self._complaints.read().strip().splitlines()
        raise Absent(f"Mitsuba's process ended ({self._process.wait()}): {lines[-1] if lines else line.strip()}")


def _close_pipe(pipe: IO[str] | None) -> None:
    try:
        if pipe is not None:
            pipe.close()
    except BrokenPipeError:
        pass


# POV-Ray 3.7: pictures of spheres, clipped quadrics and Boolean solids, one shadowed light, no antialiasing.
#
# Its axes are left-handed, so its picture is the mirror image of ours. The time is the trace time that it prints:
# parsing is not in it.

POVRAY_HEADER = """#version 3.7;
global_settings { assumed_gamma 1.0 max_trace_level 4 }
camera { location <0,0,-3> direction <0,0,1> right x up y }
light_source { <3,4,-5> rgb 1 }
#declare T = texture { pigment { rgb 0.8 } finish { ambient 0.1 diffuse 0.8 } };
"""
POVRAY_OBJECTS = {
    "spheres": "sphere {{ {c}, {r} texture {{ T }} }}",
    "quadrics": (
        "quadric {{ <1,1,1>,<0,0,0>,<0,0,0>,-1 clipped_by {{ box {{ -1.01, 1.01 }} }}"
        " bounded_by {{ clipped_by }} scale {r} translate {c} texture {{ T }} }}"
    ),
    "csg": (
        "difference {{ intersection {{ sphere {{ 0, 1 }} box {{ -0.75, 0.75 }} }}"
        " cylinder {{ -x, x, 0.4 }} cylinder {{ -y, y, 0.4 }} cylinder {{ -z, z, 0.4 }}"
        " scale {r} translate {c} texture {{ T }} }}"
    ),
}


def _povray_version() -> str:
    program = shutil.which("povray")
    if program is None:
        raise Absent("not installed: apt-get install povray (Debian), brew install povray (macOS)")
    done = subprocess.run([program, "--version"], capture_output=True, text=True, check=False)
    found = re.search(r"POV-Ray ([\d.]*\d)", done.stderr + done.stdout)
    return f"POV-Ray {found.group(1) if found else 'of unknown version'}"


POVRAY_TRACE = Peer("POV-Ray", "trace time", _povray_version)


def write_povray(path: Path, kind: str, balls: BallRows) -> None:
    """A scene file with an object of a kind in the place of each ball."""
    lines = [
        POVRAY_OBJECTS[kind].format(c=f"<{c[0]!r},{c[1]!r},{c[2]!r}>", r=repr(r))
        for c, r in zip(balls.centers.astype(float).tolist(), balls.radii.astype(float).tolist(), strict=True)
    ]
    path.write_text(POVRAY_HEADER + "\n".join(lines) + "\n")


def trace_povray(scene: Path, width: int) -> tuple[float, Floats]:
    """(trace time in seconds, brightness (width, width) in [0, 1], mirrored to be like ours)."""
    target = scene.with_suffix(".png")
    options = [f"+W{width}", f"+H{width}", "-A", "-D", f"+WT{thread_count()}", f"+O{target}"]
    done = subprocess.run(["povray", f"+I{scene}", *options], capture_output=True, text=True, check=False)
    found = re.search(r"Trace Time:.*\(([\d.]+) seconds\)", done.stderr)
    if done.returncode or found is None:
        lines = done.stderr.strip().splitlines()
        raise Absent(f"POV-Ray ended with {done.returncode}: {lines[-1] if lines else 'it said nothing'}")
    with Image.open(target) as image:
        pixels = np.asarray(image.convert("RGB"), dtype=float)[:, ::-1]
    return float(found.group(1)), pixels.max(axis=-1) / 255


# Raysect: nearest hits on spheres, double precision, one Python call for each ray, one core.


def _raysect_version() -> str:
    version = distribution("raysect")
    module("raysect.core", "raysect")
    return f"Raysect {version}"


RAYSECT = Peer("Raysect", "float64, one core", _raysect_version)


class RaysectScene:
    """Balls and rays (M, 3) as Raysect's objects; making the rays is not timed."""

    def __init__(self, balls: BallRows, origins: Singles, directions: Singles) -> None:
        core: Any = module("raysect.core", "raysect")
        primitive: Any = module("raysect.primitive", "raysect")
        self.world = core.World()
        for center, radius in zip(balls.centers.tolist(), balls.radii.tolist(), strict=True):
            primitive.Sphere(radius, parent=self.world, transform=core.translate(*center))
        self.rays = [
            core.Ray(core.Point3D(*o), core.Vector3D(*d))
            for o, d in zip(origins.tolist(), directions.tolist(), strict=True)
        ]
        self.world.hit(self.rays[0])

    def first_hits(self) -> tuple[float, Floats]:
        """(seconds, t (M,), inf for a miss)."""
        hit, inf = self.world.hit, np.inf
        begin = time.perf_counter()
        t = [found.ray_distance if (found := hit(ray)) is not None else inf for ray in self.rays]
        return time.perf_counter() - begin, np.array(t)


# trimesh with Embree: nearest hits on boxes as meshes of twelve triangles, single precision.


def _trimesh_version() -> str:
    version = distribution("trimesh")
    distribution("embreex")
    if not module("trimesh.ray", "trimesh").has_embree:
        raise Absent("trimesh finds no Embree: pip install embreex")
    return f"trimesh {version}"


TRIMESH = Peer("trimesh", "Embree, float32, triangles", _trimesh_version)


class TrimeshScene:
    """Boxes as one mesh, and rays (M, 3)."""

    def __init__(self, boxes: BoxRows, origins: Singles, directions: Singles) -> None:
        library: Any = module("trimesh", "trimesh")
        block = library.creation.box(extents=(2, 2, 2))
        points = np.einsum("nij,nvj->nvi", boxes.turns, block.vertices[None] * boxes.halves[:, None])
        points += boxes.centers[:, None]
        faces = block.faces[None] + len(block.vertices) * np.arange(len(boxes.centers))[:, None, None]
        self.mesh = library.Trimesh(points.reshape(-1, 3), faces.reshape(-1, 3), process=False)
        self.origins, self.directions = origins.astype(float), directions.astype(float)
        self.seconds()

    def seconds(self) -> float:
        begin = time.perf_counter()
        self.mesh.ray.intersects_first(self.origins, self.directions)
        return time.perf_counter() - begin

    def distances(self) -> Floats:
        """t (M,), inf for a miss."""
        _, ray, points = self.mesh.ray.intersects_id(
            self.origins, self.directions, multiple_hits=False, return_locations=True
        )
        t = np.full(len(self.origins), np.inf)
        t[ray] = np.linalg.norm(points - self.origins[ray], axis=1)
        return t
