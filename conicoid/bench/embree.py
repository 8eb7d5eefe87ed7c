"""Embree 4: nearest hits on spheres and its tree over them, through the library in the wheel `embreex`.

Single precision, one `rtcIntersect1` for each ray. It is called from a compiled loop, on as many threads as
Conicoid uses, so a ray costs what Embree takes and a plain call.
"""

from __future__ import annotations

import ctypes
import functools
import time
from pathlib import Path
from typing import Any

import numpy as np

from ..engine.threads import run_chunks, thread_count
from .peer import Absent, Peer, distribution, module
from .scenes import Balls, Floats, Singles

SPHERE_POINT, VERTEX_BUFFER, FLOAT4, QUALITY_HIGH = 50, 1, 0x9004, 2  # of Embree's headers
_CHUNK = 16384


def _version() -> str:
    version = distribution("embreex")
    distribution("numba")
    _library()
    return f"Embree 4 (embreex {version})"


PEER = Peer("Embree", "rtcIntersect1, float32", _version)


@functools.cache
def _library() -> Any:
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
    _declare(library)
    return library


def _declare(library: Any) -> None:
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

    def __init__(self, balls: Balls) -> None:
        library = self._library = _library()
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
        call, scene, trace = self._library.rtcIntersect1, self._scene, _trace()
        trace(call, scene, origins, directions, t, 0, 0)
        begin = time.perf_counter()
        run_chunks(lambda a, b: trace(call, scene, origins, directions, t, a, b), len(t), _CHUNK)
        return time.perf_counter() - begin, t.astype(float)


@functools.cache
def _trace() -> Any:
    """The loop over rays, compiled."""
    return module("numba", "numba").njit(nogil=True)(_calls)


def _calls(call: Any, scene: int, origins: Singles, directions: Singles, t: Singles, first: int, last: int) -> None:
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
