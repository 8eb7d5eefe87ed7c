"""Work on many processes and machines: `Workers` around any executor, and `processes` of this machine.

Every query of a scene, and `render`, take `executor=`: one of the standard library's or loky's, mpi4py's or Dask's, a
Dask client, or a `Workers`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .._util.foreign_names import module_attribute_error
from .processes import Processes
from .workers import Workers

__all__ = ["Processes", "Workers"]

if not TYPE_CHECKING:  # else checkers would let any name be asked for

    def __getattr__(name: str) -> Any:
        raise module_attribute_error("conicoid.parallel", name, __all__)

    def __dir__() -> list[str]:
        return sorted(__all__)
