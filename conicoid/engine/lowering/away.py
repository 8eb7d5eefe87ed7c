"""How far bodies of a kind are from the first of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...shapes.distinct import distinct_places
from ...shapes.repeated import Repeated, Shifts, carried_away
from ..tables import Floats, Ints


@dataclass(frozen=True)
class Away:
    """Along each axis the different distances, rounded once, and which of them each body has. `away[which]`: (n, 3)."""

    values: tuple[Floats, Floats, Floats]
    index: Ints  # (3, bodies)

    @classmethod
    def of(cls, shifts: Shifts) -> Away:
        """Of bodies with these shifts, of which there is at least one."""
        base, index = shifts.of(0), np.empty_like(shifts.index)
        values = []
        for axis, known in enumerate(shifts.values):
            used = np.bincount(shifts.index[axis], minlength=len(known)) > 0
            index[axis] = (np.cumsum(used, dtype=np.int32) - np.int32(1))[shifts.index[axis]]
            values.append(np.array([float(known[k] - base[axis]) for k in np.flatnonzero(used).tolist()]))
        return cls((values[0], values[1], values[2]), index)

    @classmethod
    def among(cls, bodies: Repeated, numbers: Ints) -> Away:
        """Of some bodies of one kind."""
        found, motion = cls.of(bodies.shifts.chosen(numbers)), bodies.motion(int(bodies.kinds[numbers[0]]))
        if motion.is_identity:
            return found
        columns = [distinct_places(np.ascontiguousarray(c)) for c in carried_away(found[:], motion).T]
        x, y, z = (values for values, _ in columns)
        return cls((x, y, z), np.array([index for _, index in columns], np.int32))

    def __len__(self) -> int:
        return self.index.shape[1]

    def __getitem__(self, which: Any) -> Floats:
        return np.stack([values[index[which]] for values, index in zip(self.values, self.index, strict=True)], axis=-1)

    @property
    def most(self) -> float:
        """The largest of all along any axis."""
        return max(float(np.abs(values).max()) for values in self.values)
