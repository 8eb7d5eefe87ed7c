"""Files of rays that memory need not hold: read piece by piece, from any of them on."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from ..engine.answers.rays import Rays, first_wrong
from ..shapes.vector import FloatArray
from .data_files import csv_pieces
from .npy import NotPlain, read_header
from .ray_file import COLUMNS
from .regular import open_regular


class RayStream:
    """Rays in a .npy file (..., 6) or a .csv file. Raises ValueError, naming the file, and OSError.

    shape: their leading shape; None for a .csv file, whose end is not known.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)
        self.shape: tuple[int, ...] | None = None
        suffix = self.path.suffix.lower()
        if suffix not in (".npy", ".csv"):
            raise ValueError(f"{self.path}: rays are read piece by piece from .npy or .csv files")
        open_regular(self.path).close()
        if suffix == ".npy":
            self._open()

    def _open(self) -> None:
        with open_regular(self.path) as file:
            try:
                header = read_header(file)
                size = os.fstat(file.fileno()).st_size - file.tell()
            except NotPlain as error:
                raise ValueError(f"{self.path}: is not a .npy file of numbers ({error})") from None
            self._start = file.tell()
        if header.kind is None or not header.shape or header.shape[-1] != 6:
            names = ", ".join(COLUMNS)
            raise ValueError(f"{self.path}: rays must be numbers of shape (..., 6), {names}; got {header}")
        if header.fortran and len(header.shape) > 1:
            raise ValueError(f"{self.path}: its columns come first: np.ascontiguousarray(rays) is read piece by piece")
        if size < header.count * header.kind.itemsize:
            raise ValueError(f"{self.path}: it ends too early")
        self._kind, self.shape = header.kind, header.shape[:-1]

    def pieces(self, most: int, skip: int = 0) -> Iterator[Rays]:
        """The rays from number `skip` on, at most so many at a time. Raises ValueError, naming a bad ray's place."""
        done = 0
        for rows, lines in self._rows(most, skip):
            origins, directions = np.ascontiguousarray(rows[:, :3]), np.ascontiguousarray(rows[:, 3:])
            wrong = first_wrong(origins, directions)
            if wrong is not None:
                place = f"{lines[wrong[0]]}" if lines else f"ray {skip + done + wrong[0]}"
                raise ValueError(f"{self.path}: {place}: {wrong[1]}")
            yield Rays(origins, directions)
            done += len(rows)

    def _rows(self, most: int, skip: int) -> Iterator[tuple[FloatArray, Sequence[int]]]:
        if self.shape is None:
            for rows, lines in csv_pieces(self.path, 6, COLUMNS, most):
                if skip < len(rows):
                    yield rows[skip:], lines[skip:]
                skip = max(0, skip - len(rows))
            return
        count, each = int(np.prod(self.shape)), 6 * self._kind.itemsize
        with open_regular(self.path) as file:
            file.seek(self._start + skip * each)
            for begin in range(skip, count, most):
                data = file.read(min(most, count - begin) * each)
                yield np.frombuffer(data, self._kind).astype(np.float64).reshape(-1, 6), ()
