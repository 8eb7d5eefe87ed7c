"""Rays in Parquet files, read piece by piece, and tables of results as such. Extra `parquet`, Apache Arrow's reader."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from .atomic import replacing
from .data_files import check_heading, named_columns
from .errors import printable
from .flat_rows import WIDTHS

_COLUMNS = ("origin x", "origin y", "origin z", "direction x", "direction y", "direction z")
_GROUP = 1 << 20
"""Rows of a group, which readers take at a time."""


def parquet_module() -> Any:
    try:
        import pyarrow.parquet
    except ImportError:
        raise ImportError(".parquet files need pyarrow: pip install 'conicoid[parquet]'") from None
    return pyarrow.parquet


class ParquetSource:
    """Six columns, by the names ox, oy, oz, dx, dy, dz or in this order, and perhaps t_min and t_max."""

    home = None

    def __init__(self, path: Path) -> None:
        module = parquet_module()
        try:
            self._file: Any = module.ParquetFile(path)
        except OSError:
            raise
        except Exception as error:  # of Arrow, which are its own
            raise ValueError(f"is not a Parquet file ({(str(error).splitlines() or [''])[0][:120]})") from None
        schema = self._file.schema_arrow
        names = [str(name) for name in schema.names]
        self.ends: tuple[str, ...] = tuple(name for name in ("t_min", "t_max") if name in names)
        others = [name for name in names if name not in WIDTHS]
        found = named_columns(others, _COLUMNS)
        if found is None:
            if len(others) != 6:
                told = printable(", ".join(names))[:120] or "none"
                raise ValueError(f"must have the columns ox, oy, oz, dx, dy, dz (and t_min, t_max), got {told}")
            check_heading(path.name, ",".join(others), _COLUMNS)
            found = others
        self._names = [*found, *self.ends]
        for name in self._names:
            kind = str(schema.field(name).type)
            if kind not in _NUMBERS:
                raise ValueError(f"column {printable(name)[:60]!r} must hold numbers, got {kind[:40]}")
        self.shape: tuple[int, ...] | None = (int(self._file.metadata.num_rows),)

    def rows(self, most: int, skip: int) -> Iterator[Any]:
        from .ray_stream import Rows

        groups: list[int] = []
        first = 0
        for group in range(self._file.num_row_groups):
            count = self._file.metadata.row_group(group).num_rows
            if first + count > skip or groups:
                groups.append(group)
            else:
                first += count
        skip -= first
        for batch in self._file.iter_batches(batch_size=most, row_groups=groups, columns=self._names):
            some = batch.slice(min(skip, batch.num_rows))
            skip -= batch.num_rows - some.num_rows
            if not some.num_rows:
                continue
            columns = {name: self._numbers(name, some.column(name)) for name in self._names}
            table = np.column_stack([columns[name] for name in self._names[:6]])
            yield Rows(table[:, :3], table[:, 3:], columns.get("t_min"), columns.get("t_max"))

    def _numbers(self, name: str, column: Any) -> Any:
        if column.null_count:
            raise ValueError(f"column {printable(name)[:60]!r} has {column.null_count} empty places")
        return column.to_numpy(zero_copy_only=False).astype(np.float64)


_NUMBERS = {"double", "float", "halffloat", *(f"{u}int{n}" for u in ("", "u") for n in (8, 16, 32, 64))}


def write_parquet(path: str | os.PathLike[str], columns: Mapping[str, Any]) -> None:
    """Columns of numbers as a table. The file appears whole or not at all. Raises OSError."""
    module = parquet_module()
    import pyarrow

    kinds = {name: pyarrow.from_numpy_dtype(column.dtype) for name, column in columns.items()}
    count = max((len(column) for column in columns.values()), default=0)
    with replacing(path) as partial, module.ParquetWriter(partial, pyarrow.schema(list(kinds.items()))) as writer:
        for begin in range(0, count, _GROUP):
            some = {name: np.asarray(column[begin : begin + _GROUP]) for name, column in columns.items()}
            writer.write_table(pyarrow.table(some))
