"""Results that are written as they come, and gone on with after a stop: a folder of columns until they are whole.

Beside `hits.csv` there is `hits.csv.parts` meanwhile: a file for each column, and `state.json`, which says for how many
rays they hold the answers, and up to which byte. What stands behind that byte is of a part that was not finished.
"""

from __future__ import annotations

import json
import os
import shutil
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from .atomic import replacing, write_text


class ResultParts:
    """The parts of results at `output`, for the work of a key. Raises ValueError where the folder is of other work."""

    def __init__(self, output: Path, key: str, resume: bool) -> None:
        self.output, self.key = output, key
        self.folder = output.with_name(output.name + ".parts")
        self.rays = self.found = 0
        self.sizes: dict[str, int] = {}
        self.kinds: dict[str, Any] = {}
        if self.folder.exists():
            if not resume:
                raise ValueError(f"{self.folder}: is left of an earlier run; --resume goes on with it, or remove it")
            self._read()
        else:
            self.folder.mkdir()

    def _read(self) -> None:
        state = self.folder / "state.json"
        if not state.exists():  # it was stopped before its first part
            return
        found = json.loads(state.read_text(encoding="utf-8"))
        if found["key"] != self.key:
            raise ValueError(f"{self.folder}: holds results of other rays, another scene or version; remove it")
        self.rays, self.found = found["rays"], found["found"]
        self.sizes, self.kinds = found["sizes"], found["kinds"]
        for name, size in self.sizes.items():
            os.truncate(self.folder / name, size)

    def add(self, columns: Mapping[str, bytes | np.ndarray[Any, Any]], rays: int, found: int) -> None:
        """Append the answers to some more rays, and what they found: bytes of a text, or rows of arrays."""
        for name, rows in columns.items():
            if not isinstance(rows, bytes):
                self.kinds[name] = [np.lib.format.dtype_to_descr(rows.dtype), list(rows.shape[1:])]
            data = rows if isinstance(rows, bytes) else np.ascontiguousarray(rows).tobytes()
            path = self.folder / name
            try:
                with open(path, "ab") as file:
                    file.write(data)
            except OSError as error:
                raise OSError(error.errno, error.strerror, os.fspath(path)) from None
            self.sizes[name] = self.sizes.get(name, 0) + len(data)
        self.rays, self.found = self.rays + rays, self.found + found
        state = dict(key=self.key, rays=self.rays, found=self.found, sizes=self.sizes, kinds=self.kinds)
        write_text(self.folder / "state.json", json.dumps(state))

    def column(self, name: str) -> np.ndarray[Any, Any]:
        """A column of numbers, mapped from the disk."""
        kind, last = np.dtype(self.kinds[name][0]), tuple(self.kinds[name][1])
        if not self.sizes[name]:
            return np.zeros((0, *last), kind)
        return np.memmap(self.folder / name, kind, "r").reshape(-1, *last)

    def finish_text(self, name: str) -> None:
        """The text of one column becomes the output."""
        with replacing(self.output) as partial:
            os.replace(self.folder / name, partial)
        shutil.rmtree(self.folder)

    def finish_arrays(self, shape: tuple[int, ...], flat: tuple[str, ...], more: Mapping[str, Any]) -> None:
        """The columns become a .npz file with more arrays, each in the rays' shape but for those that are flat."""
        with (
            replacing(self.output) as partial,
            zipfile.ZipFile(partial, "w", zipfile.ZIP_STORED, allowZip64=True) as archive,
        ):
            for name, (kind, last) in self.kinds.items():
                leading = (self.rays,) if name in flat else shape
                header = dict(descr=kind, fortran_order=False, shape=(*leading, *last))
                with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                    np.lib.format.write_array_header_1_0(member, header)
                    with open(self.folder / name, "rb") as column:
                        shutil.copyfileobj(column, member, 1 << 20)
            for name, array in more.items():
                with archive.open(f"{name}.npy", "w") as member:
                    np.lib.format.write_array(member, np.asanyarray(array), allow_pickle=False)
        shutil.rmtree(self.folder)
