"""Rays in .npz files, read piece by piece, with the same distrust as of whole ones."""

from __future__ import annotations

import os
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Any

import numpy as np

from .errors import printable
from .flat_rows import WIDTHS, broadcast_rows, leading_shape
from .npy import Header, NotPlain, read_header
from .npz import DAMAGE, Archive, reason_of
from .regular import open_regular

_SKIPPED = 4 << 20
_STARTS, _HOME = "starts", "starts_home"


class NpzSource:
    """The arrays `origins` and `directions`, perhaps `t_min` and `t_max`, and what `Rays.save` adds."""

    def __init__(self, path: Path) -> None:
        self._path = path
        with open_regular(path) as file:
            archive = Archive(file, os.fstat(file.fileno()).st_size)
            known = (*WIDTHS, _STARTS)
            members = {name: archive.members[name] for name in known if name in archive.members}
            headers = {name: _header(archive.zip, info) for name, info in members.items()}
            shapes = {name: header.shape for name, header in headers.items() if name != _STARTS}
            if not {"origins", "directions"} <= set(shapes):
                names = printable(", ".join(archive.members))[:120] or "nothing"
                raise ValueError(f"must hold the arrays origins and directions (and t_min, t_max), got {names}")
            rays = leading_shape(shapes)
            count = int(np.prod(rays))
            self.shape: tuple[int, ...] | None = rays
            self._count = count
            whole = {name: (*rays, *last) for name, last in WIDTHS.items()} | {_STARTS: (count,)}
            self._streamed = {
                name: (info, headers[name]) for name, info in members.items()
                if headers[name].shape == whole[name] and not (headers[name].fortran and len(whole[name]) > 1)
            }  # fmt: skip
            small = archive.arrays([name for name in members if name not in self._streamed], ())
            home = archive.arrays([_HOME]).get(_HOME)
            self.home = None if home is None else home.astype(np.uint8).tobytes() or None
            starts = small.pop(_STARTS, None)
            if starts is not None and starts.shape != (1,):
                raise ValueError(f"starts must have shape (1,) or ({count},), got {starts.shape}")
            self._start = starts
            self._small = {name: broadcast_rows(array, rays) for name, array in small.items()}
        self.ends = tuple(name for name in ("t_min", "t_max") if name in members)

    def rows(self, most: int, skip: int) -> Iterator[Any]:
        from .ray_stream import Rows

        with open_regular(self._path) as file, zipfile.ZipFile(file) as archive:
            try:
                opened = {name: _Member(archive, *told, skip) for name, told in self._streamed.items()}
                for begin in range(skip, self._count, most):
                    end = min(self._count, begin + most)
                    some = {name: member.next(end - begin) for name, member in opened.items()}
                    some |= {name: read(begin, end) for name, read in self._small.items()}
                    starts = some.get(_STARTS, self._start)
                    if starts is not None:
                        starts = np.broadcast_to(starts, (end - begin,)) if len(starts) == 1 else starts
                        some[_STARTS] = np.ascontiguousarray(starts.astype(np.int32))
                    yield Rows(**some)
            except (NotPlain, ValueError):
                raise
            except DAMAGE as error:
                raise NotPlain(reason_of(error)) from None


class _Member:
    """An array of an archive, read forward row by row."""

    def __init__(self, archive: zipfile.ZipFile, info: zipfile.ZipInfo, header: Header, skip: int) -> None:
        self._file: IO[bytes] = archive.open(info)
        read_header(self._file)
        assert header.kind is not None
        self._kind = header.kind
        self._last = header.shape[-1:] if info.filename.removesuffix(".npy") in ("origins", "directions") else ()
        self._each = self._kind.itemsize * int(np.prod(self._last))
        left = skip * self._each
        while left:
            left -= len(_exactly(self._file, min(left, _SKIPPED)))

    def next(self, count: int) -> Any:
        data = _exactly(self._file, count * self._each)
        return np.frombuffer(data, self._kind).astype(np.float64).reshape(-1, *self._last)


def _header(archive: zipfile.ZipFile, info: zipfile.ZipInfo) -> Header:
    name = info.filename.removesuffix(".npy")
    try:
        if info.flag_bits & 0x1:
            raise NotPlain("it is encrypted")
        with archive.open(info) as file:
            header = read_header(file)
    except NotPlain as error:
        raise ValueError(f"{name} is not an array of numbers ({error})") from None
    except DAMAGE as error:
        raise NotPlain(reason_of(error)) from None
    if header.kind is None:
        raise ValueError(f"{name} must hold numbers, got {header}")
    if info.file_size != header.length + header.count * header.kind.itemsize:
        raise ValueError(f"{name} is not an array of numbers (it has {info.file_size:,} bytes)")
    return header


def _exactly(file: IO[bytes], count: int) -> bytes:
    data = file.read(count)
    if len(data) < count:
        raise NotPlain("it ends too early")
    return data
