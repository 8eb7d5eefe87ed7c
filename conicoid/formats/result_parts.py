"""Results that are written as they come, and gone on with after a stop: a folder of columns until they are whole.

Beside `hits.csv` there is `hits.csv.parts` meanwhile: a file for each column, and `state.json`, which says for how many
rays they hold the answers, and up to which byte. What stands behind that byte is of a part that was not finished.
"""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from .atomic import replacing, write_text
from .parquet_file import write_parquet
from .stored import Stored, write_npy, write_npz
from .zarr_folder import write_zarr


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

    def stored(self, name: str, shape: tuple[int, ...]) -> Stored:
        """A column as an array whose rows have a leading shape."""
        column = self.column(name)
        return Stored((column,), (*shape, *column.shape[1:]))

    def finish_arrays(self, arrays: Mapping[str, Stored], more: Mapping[str, Any]) -> None:
        """Stored arrays and some in memory become the output, a .npz file or a .zarr folder."""
        if self.output.suffix.lower() == ".zarr":
            write_zarr(self.output, arrays, more)
        else:
            write_npz(self.output, arrays, more)
        shutil.rmtree(self.folder)

    def finish_array(self, array: Stored) -> None:
        """One stored array becomes the output, a .npy file."""
        write_npy(self.output, array)
        shutil.rmtree(self.folder)

    def finish_table(self) -> None:
        """All columns become the output, a .parquet file."""
        write_parquet(self.output, {name: self.column(name) for name in self.kinds})
        shutil.rmtree(self.folder)
