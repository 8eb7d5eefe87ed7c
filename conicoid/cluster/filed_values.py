"""Answers that are numbers of rays, `occluded`, `lengths` and `line_integral`, on their way into a file."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..engine.answers.weights import BODY
from ..formats.ray_file import check_output, lines_of_columns, quoted
from ..formats.result_parts import ResultParts
from ..formats.value_columns import names_of_integrals, names_of_lengths

if TYPE_CHECKING:
    from ..scene import Scene

SUFFIXES = (".npy", ".npz", ".csv", ".parquet", ".zarr")
_TEXT = "lines"


class FiledValues:
    """An array (...) or (..., columns) in .npy, .npz and .zarr, there by the query's name; else a table of columns."""

    def __init__(self, scene: Scene, query: str, output: Path, options: Mapping[str, Any]) -> None:
        check_output(output, SUFFIXES)
        self.scene, self.query, self.options = scene, query, dict(options)
        self.suffix = output.suffix.lower()
        self._nothing = self._of_no_rays()
        self._parts = ResultParts(output, "", resume=False)

    @property
    def rays(self) -> int:
        return self._parts.rays

    def add(self, answer: Any) -> None:
        """The answers to some more rays, (...) or (..., columns)."""
        answer = answer.reshape(-1, *self._nothing.shape[1:])
        rows: dict[str, Any] = {self.query: answer}
        if self.suffix == ".parquet":
            rows = self._columns(answer)
        elif self.suffix == ".csv":
            lines = lines_of_columns(self._columns(answer))
            heading = next(lines)
            rows = {_TEXT: (("" if self.rays else heading) + "".join(lines)).encode()}
        self._parts.add(rows, len(answer), len(answer))

    def finish(self, shape: tuple[int, ...] | None, _home: bytes | None) -> None:
        """Put all together, for rays of this leading shape, or for those that came one after the other."""
        parts = self._parts
        if not parts.rays:
            self.add(self._nothing)
        if self.suffix == ".csv":
            parts.finish_text(_TEXT)
        elif self.suffix == ".parquet":
            parts.finish_table()
        else:
            whole = parts.stored(self.query, shape or (parts.rays,))
            if self.suffix == ".npy":
                parts.finish_array(whole)
            else:
                parts.finish_arrays({self.query: whole}, {})

    def give_up(self) -> None:
        """Remove what is there of it."""
        shutil.rmtree(self._parts.folder, ignore_errors=True)

    def _of_no_rays(self) -> Any:
        options, nothing = dict(self.options), np.zeros((0, 3))
        values = (options.pop("values"),) if self.query == "line_integral" else ()
        return getattr(self.scene, self.query)(*values, nothing, nothing, **options)

    def _columns(self, answer: Any) -> dict[str, Any]:
        if self.query == "occluded":
            return {self.query: answer}
        if self.query == "lengths":
            names = names_of_lengths(self.scene, self.options.get("by", BODY))
        else:
            names = names_of_integrals(answer.shape[1:])
        rows = answer.reshape(len(answer), len(names))
        return {quoted(name): rows[:, k] for k, name in enumerate(names)}
