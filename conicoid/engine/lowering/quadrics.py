"""Quadrics as anchors and forms: what are one another moved share all numbers but those of their anchors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...shapes.distinct import distinct_places
from ..tables import ANCHOR_SIZE, FORM_SIZE, Floats, Ints, whole_quadrics


@dataclass
class Quadrics:
    """Two tables, as `Tables` has them. `quadrics[which]` are whole rows (n, 19), made when they are asked for."""

    rows: Floats  # (n, 4) anchor, row of the form
    forms: Floats  # (forms, 16)

    @classmethod
    def of(cls, anchors: Floats, forms: Floats) -> Quadrics:
        """Those with a form each."""
        return cls(np.column_stack([anchors[:, :3], np.arange(len(anchors), dtype=np.float64)]), forms)

    @classmethod
    def empty(cls, form_of: Ints, forms: int) -> Quadrics:
        """Room for those with these rows of so many forms."""
        rows = np.empty((len(form_of), ANCHOR_SIZE))
        rows[:, 3] = form_of
        return cls(rows, np.empty((forms, FORM_SIZE)))

    @property
    def form_of(self) -> Any:
        """(n,) the row of each one's form."""
        return self.rows[:, 3].astype(np.intp)

    def __len__(self) -> int:
        return len(self.rows)

    def __getitem__(self, which: Any) -> Floats:
        return whole_quadrics(self.rows[which], self.forms)

    def chosen(self, which: Any) -> Quadrics:
        """Some of them; the table of forms stays."""
        return Quadrics(self.rows[which], self.forms)

    def compact(self) -> tuple[Quadrics, Any]:
        """The same without forms that nothing has, and which forms these are."""
        used, of = distinct_places(self.form_of)
        rows = self.rows.copy()
        rows[:, 3] = of
        return Quadrics(rows, self.forms[used]), used
