"""Rays on forms: quadratics A t² + B t + C with whole coefficients, their simple roots, and the order of these.

Origins and directions are floats, so with a common power of two W they are whole numbers O / W and D / W. Two
quadratics share a root if their resultant (A1 C2 - A2 C1)² - (A1 B2 - A2 B1)(B1 C2 - B2 C1) is zero. If A1 B2 - A2 B1 is
not zero then, that root is -(A1 C2 - A2 C1) / (A1 B2 - A2 B1).
"""

import itertools
import math
from collections.abc import Iterable, Iterator, Sequence
from functools import cmp_to_key
from typing import Any

from flint import arb, ctx, fmpz, fmpz_mat

from .forms import Form, proportional
from .numbers import Number, ball, sign
from .solids import Body, forms_of

BITS = 160
EQUAL_BITS = 1000
"""Roots of rounded quadratics that agree to so many bits count as equal."""
NEAR = 2.0**-48
"""Floats that differ by a larger share have different roots."""
NEARLY_NONE = 2200
"""A sum of rounded terms below 2^-2200 of them counts as zero."""
Quadratic = tuple[Any, Any, Any]


class Table:
    """The distinct surfaces of some bodies; `places[id of form]` is (surface, 1 or -1: inside alike or opposite).

    Curved surfaces with opposite insides stand apart, as a ray within one is outside of either; `twins` knows them.
    """

    def __init__(self, bodies: Sequence[Body]) -> None:
        self.bodies = list(bodies)
        self.forms: list[Form] = []
        self.places: dict[int, tuple[int, int]] = {}
        self.faces: list[dict[int, int]] = []  # of each body, the surface of each face
        for body in bodies:
            own = [] if body.sheet is None else [body.sheet.surface]
            clip = body.formula if body.sheet is None else body.sheet.clip
            for form in (*own, *forms_of(clip)):
                self.places[id(form)] = self._place(form)
            self.faces.append({f.face: self.places[id(f)][0] for f in (own or forms_of(body.formula))})
        self.parts = [_part(form) for form in self.forms]
        self.twins = [
            [j for j, g in enumerate(self.forms) if i == j or (not f.flat and proportional(f, g))]
            for i, f in enumerate(self.forms)
        ]
        """For each surface those with the same points, itself among them."""

    def _place(self, form: Form) -> tuple[int, int]:
        for index, known in enumerate(self.forms):
            sense = proportional(form, known)
            if sense > 0 or (sense and form.flat):
                return index, sense
        self.forms.append(form)
        return len(self.forms) - 1, 1

    def quadratics(self, origins: Any, directions: Any) -> Iterator[Sequence[Quadratic]]:
        """Return for each ray the quadratic of each surface."""
        rays = [whole_ray(o, d) for o, d in zip(origins, directions, strict=True)]
        if not self.forms or not rays:
            return iter([()] * len(rays))
        columns = zip(*(_products(*ray) for ray in rays), strict=True)
        values = [fmpz_mat(len(rays), len(rows[0]), list(itertools.chain.from_iterable(rows))) for rows in columns]
        sizes = [tuple(max(x.height_bits() for x in part) for part in (o, d, (w,))) for o, d, w in rays]
        found = []
        for form, parts in zip(self.forms, self.parts, strict=True):
            rows = zip(*(_times(v, parts) for v in values), strict=True)
            found.append(list(rows) if form.exact else _put_zeros(parts[1], sizes, rows))
        return zip(*found, strict=True)


def _part(form: Form) -> dict[int, list[fmpz]]:
    """Return the ten whole coefficients, for each square-free s."""
    every = {s for k in form.whole for s in k} or {1}
    return {s: [k.get(s, fmpz(0)) for k in form.whole] for s in sorted(every)}


def _times(values: fmpz_mat, parts: dict[int, list[fmpz]]) -> list[Any]:
    """Return rows of values times as many coefficients: whole numbers, or numbers of whole parts."""
    size = values.ncols()
    columns = {s: (values * fmpz_mat(size, 1, k[:size])).entries() for s, k in parts.items()}
    if set(columns) == {1}:
        return columns[1]
    return [Number(dict(zip(columns, entries, strict=True))) for entries in zip(*columns.values(), strict=True)]


def whole_ray(origin: Sequence[float], direction: Sequence[float]) -> tuple[list[fmpz], list[fmpz], fmpz]:
    """Return whole numbers O, D and W with origin = O / W and direction = D / W."""
    parts = [float(x).as_integer_ratio() for x in (*origin, *direction)]
    w = max(q for _, q in parts)
    numbers = [fmpz(p * (w // q)) for p, q in parts]
    return numbers[:3], numbers[3:], fmpz(w)


def _products(o: list[fmpz], d: list[fmpz], w: fmpz) -> tuple[list[fmpz], ...]:
    """Return the factors of the coefficients in A, B and C."""
    (x, y, z), (u, v, r) = o, d
    return (
        [u * u, v * v, r * r, u * v, u * r, v * r],
        [2 * x * u, 2 * y * v, 2 * z * r, x * v + y * u, x * r + z * u, y * r + z * v, w * u, w * v, w * r],
        [x * x, y * y, z * z, x * y, x * z, y * z, w * x, w * y, w * z, w * w],
    )


def _put_zeros(k: list[fmpz], sizes: Sequence[tuple[int, ...]], rows: Iterable[Quadratic]) -> list[Quadratic]:
    """Put zero where rounded terms cancel. `sizes` are the bits of each ray's O, D and W."""
    m, n, last = (max(x.height_bits() for x in part) for part in (k[:6], k[6:9], k[9:]))
    found = []
    for (o, d, w), (a, b, c) in zip(sizes, rows, strict=True):
        terms = (m + 2 * d, max(m + o, n + w) + d, max(m + 2 * o, n + o + w, last + 2 * w))
        found.append(
            tuple(fmpz(0) if v.height_bits() + NEARLY_NONE < t else v for v, t in zip((a, b, c), terms, strict=True))
        )
    return found


class Root:
    """A simple root of a surface on a ray: where the form falls (slope 0) or rises (slope 1)."""

    __slots__ = ("_ball", "_bits", "discriminant", "exact", "quadratic", "slope", "surface")

    def __init__(self, surface: int, slope: int, quadratic: Quadratic, discriminant: Any, exact: bool) -> None:
        self.surface, self.slope, self.quadratic, self.discriminant, self.exact = (
            surface,
            slope,
            quadratic,
            discriminant,
            exact,
        )
        self._bits, self._ball = 0, None

    def ball(self, bits: int = BITS) -> arb:
        """Return an interval that holds the root, of about that relative precision."""
        if bits > self._bits:
            with ctx.workprec(bits + 10):
                self._ball = self._value(bits + 10)
            self._bits = bits
        return self._ball

    def _value(self, bits: int) -> arb:
        a, b, c = (ball(x, bits) for x in self.quadratic)
        if a == 0:
            return -c / b
        s = ball(self.discriminant, bits).sqrt()
        # (-B + sigma sqrt D) / 2 A without cancellation, sigma being -1 where the form falls
        if b >= 0:
            q = -(b + s) / 2
            return c / q if self.slope else q / a
        q = (s - b) / 2
        return q / a if self.slope else c / q

    @property
    def place(self) -> float:
        """The root rounded to a float, or infinite."""
        try:
            return float(self.ball().mid())
        except OverflowError:
            return math.inf if self.ball() > 0 else -math.inf

    @property
    def sign(self) -> int:
        """The side of the ray's origin on which the root lies."""
        _, b, c = self.quadratic
        if not c and sign(b) == 2 * self.slope - 1:
            return 0
        return 1 if self.ball() > 0 else -1


def roots(surface: int, quadratic: Quadratic, exact: bool) -> list[Root]:
    """Return the simple real roots; a double root is a touch and counts as none."""
    a, b, c = quadratic
    if not a:
        return [Root(surface, int(sign(b) > 0), quadratic, b, exact)] if b else []
    p, q = b * b, 4 * a * c
    discriminant = p - q
    if not exact and abs(discriminant) << NEARLY_NONE < max(p, abs(q)):
        return []
    if sign(discriminant) <= 0:
        return []
    return [Root(surface, slope, quadratic, discriminant, exact) for slope in ((0, 1) if sign(a) > 0 else (1, 0))]


def equal(r: Root, s: Root) -> bool:
    """Decide equality by algebra, for roots of exact quadratics."""
    (a1, b1, c1), (a2, b2, c2) = r.quadratic, s.quadratic
    if not a1 and not a2:
        return not b1 * c2 - b2 * c1
    m, n = a1 * b2 - a2 * b1, a1 * c2 - a2 * c1
    if not m:
        return not n and bool(a1) and (sign(a1) == sign(a2)) == (r.slope == s.slope)
    if n * n - m * (b1 * c2 - b2 * c1):
        return False
    # at the common root x = -n / m the slope of a form is that of 2 a x + b
    return all(sign(b * m - 2 * a * n) * sign(m) == 2 * x.slope - 1 for x in (r, s) for a, b, _ in [x.quadratic])


def compare(r: Root, s: Root) -> int:
    """Return -1, 0, 1 for r < s, r = s, r > s."""
    if r is s:
        return 0
    bits = BITS
    while True:
        p, q = r.ball(bits), s.ball(bits)
        if p < q:
            return -1
        if p > q:
            return 1
        if r.exact and s.exact:
            if bits == BITS and r.surface != s.surface and equal(r, s):
                return 0
        elif bits > EQUAL_BITS:
            return 0
        bits *= 4
        assert bits < 1 << 20, "two roots that cannot be parted"


def in_order(every: list[Root]) -> list[list[Root]]:
    """Return groups of equal roots, from left to right."""
    places = [(root.place, k) for k, root in enumerate(every)]
    places.sort()
    ordered = [every[k] for _, k in places]
    close = [abs(q - p) <= NEAR * abs(p) or not math.isfinite(q - p) for (p, _), (q, _) in itertools.pairwise(places)]
    senses = [compare(p, q) if near else -1 for p, q, near in zip(ordered, ordered[1:], close, strict=False)]
    if any(sense > 0 for sense in senses):
        ordered.sort(key=cmp_to_key(compare))
        senses = [compare(p, q) for p, q in itertools.pairwise(ordered)]
    groups = [ordered[:1]] if ordered else []
    for root, sense in zip(ordered[1:], senses, strict=True):
        if sense:
            groups.append([])
        groups[-1].append(root)
    return groups


def negative_at_start(form: Form, quadratic: Quadratic) -> bool:
    """Return whether the form is negative towards t = -inf.

    A ray within a plane counts as if the plane stood further along its normal, the normal taken so that its first
    component is positive. A ray within a curved surface is outside.
    """
    a, b, c = map(sign, quadratic)
    return a < 0 if a else b > 0 if b else c < 0 or (c == 0 and form.side > 0)
