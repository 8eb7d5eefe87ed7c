"""Boxes along the axes with ends in fractions, any of them infinite: what is known of where a region lies."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from fractions import Fraction

from .placement import Placement, Point

End = Fraction | None


@dataclass(frozen=True, slots=True)
class Extent:
    """low[i] <= x[i] <= high[i]; None where there is no end."""

    low: tuple[End, End, End] = (None, None, None)
    high: tuple[End, End, End] = (None, None, None)

    def end(self, axis: int, lower: bool) -> End:
        """One of the six ends."""
        return (self.low if lower else self.high)[axis]

    def common(self, other: Extent) -> Extent:
        """The part in both."""
        if other is EVERYWHERE or self is EVERYWHERE:
            return self if other is EVERYWHERE else other
        lows = [_tighter(max, a, b) for a, b in zip(self.low, other.low, strict=True)]
        highs = [_tighter(min, a, b) for a, b in zip(self.high, other.high, strict=True)]
        return Extent((lows[0], lows[1], lows[2]), (highs[0], highs[1], highs[2]))

    def around(self, other: Extent) -> Extent:
        """The box around both."""
        lows = [_looser(min, a, b) for a, b in zip(self.low, other.low, strict=True)]
        highs = [_looser(max, a, b) for a, b in zip(self.high, other.high, strict=True)]
        return Extent((lows[0], lows[1], lows[2]), (highs[0], highs[1], highs[2]))

    def placed(self, place: Placement) -> Extent:
        """The box after the turn and the shift of a place, before its outer motion."""
        lows: list[End] = []
        highs: list[End] = []
        for source, sign, shift in zip(place.turn.sources, place.turn.signs, place.shift, strict=True):
            ends = [None if end is None else sign * end + shift for end in (self.low[source], self.high[source])]
            lows.append(ends[0 if sign > 0 else 1])
            highs.append(ends[1 if sign > 0 else 0])
        return Extent((lows[0], lows[1], lows[2]), (highs[0], highs[1], highs[2]))

    @property
    def is_empty(self) -> bool:
        """Whether it has no volume."""
        return any(
            low is not None and high is not None and low >= high for low, high in zip(self.low, self.high, strict=True)
        )

    def least(self, normal: Point) -> End:
        """The least normal·x; None if there is none."""
        return self._sum(normal, self.low, self.high)

    def most(self, normal: Point) -> End:
        """The largest normal·x; None if there is none."""
        return self._sum(normal, self.high, self.low)

    @staticmethod
    def _sum(normal: Point, along: tuple[End, End, End], against: tuple[End, End, End]) -> End:
        total = Fraction(0)
        for n, a, b in zip(normal, along, against, strict=True):
            if n:
                end = a if n > 0 else b
                if end is None:
                    return None
                total += n * end
        return total

    def square_distances(self, center: Point, axes: Iterable[int]) -> tuple[Fraction, End]:
        """Least and largest square of the distance to `center`, measured along some of the axes."""
        least, most = Fraction(0), Fraction(0)
        bounded = True
        for i in axes:
            low, high, c = self.low[i], self.high[i], center[i]
            if low is not None and c < low:
                least += (low - c) ** 2
            elif high is not None and c > high:
                least += (c - high) ** 2
            if low is None or high is None:
                bounded = False
            else:
                most += max(c - low, high - c) ** 2
        return least, most if bounded else None


EVERYWHERE = Extent()


def _looser(choose: Callable[[Fraction, Fraction], Fraction], a: End, b: End) -> End:
    return None if a is None or b is None else choose(a, b)


def _tighter(choose: Callable[[Fraction, Fraction], Fraction], a: End, b: End) -> End:
    if a is None or b is None:
        return b if a is None else a
    return choose(a, b)
