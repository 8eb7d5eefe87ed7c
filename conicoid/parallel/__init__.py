"""Work on many processes and machines: `Workers` around any executor, and `Processes` of this machine.

Every query of a scene, and `render`, take `executor=`: one of the standard library's or loky's, mpi4py's or Dask's, a
Dask client, or a `Workers`.
"""

from __future__ import annotations

from .processes import Processes
from .workers import Workers

__all__ = ["Processes", "Workers"]
