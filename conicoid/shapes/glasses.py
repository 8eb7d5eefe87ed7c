"""A catalogue of published refractive indices, by name: glasses of four makers, crystals, liquids, plastics, metals."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import cached_property
from typing import Any

from .dispersion import Dispersion, Edlen, Schott, Sellmeier, Tabulated
from .suggestion import close_to
from .validate import shown

Made = Callable[[], Dispersion]

_CRYSTALS: tuple[tuple[str, str, tuple[float, float], float, tuple[float, ...], str], ...] = (
    ("fused silica", "SiO2", (0.21, 6.7), 0.0, (0.6961663, 0.0684043, 0.4079426, 0.1162414, 0.8974794, 9.896161),
     "I. H. Malitson, J. Opt. Soc. Am. 55 (1965), 1205; to 6.7 μm by C. Z. Tan, J. Non-Cryst. Solids 223 (1998), 158"),
    ("calcium fluoride", "CaF2", (0.23, 9.7), 0.0,
     (0.5675888, 0.050263605, 0.4710914, 0.1003909, 3.8484723, 34.649040), "I. H. Malitson, Appl. Opt. 2 (1963), 1103"),
    ("magnesium fluoride", "MgF2", (0.2, 7.0), 0.0,
     (0.48755108, 0.04338408, 0.39875031, 0.09461442, 2.3120353, 23.793604),
     "M. J. Dodge, Appl. Opt. 23 (1984), 1980; the ordinary ray"),
    ("barium fluoride", "BaF2", (0.2652, 10.346), 0.0, (0.643356, 0.057789, 0.506762, 0.10968, 3.8261, 46.3864),
     "I. H. Malitson, J. Opt. Soc. Am. 54 (1964), 628"),
    ("lithium fluoride", "LiF", (0.1, 11.0), 0.0, (0.92549, 0.07376, 6.96747, 32.79),
     "H. H. Li, J. Phys. Chem. Ref. Data 5 (1976), 329"),
    ("sodium chloride", "NaCl", (0.2, 30.0), 0.00055,
     (0.198, 0.05, 0.48398, 0.1, 0.38696, 0.128, 0.25998, 0.158, 0.08796, 40.5, 3.17064, 60.98, 0.30038, 120.34),
     "H. H. Li, J. Phys. Chem. Ref. Data 5 (1976), 329"),
    ("potassium bromide", "KBr", (0.2, 42.0), 0.39408,
     (0.79221, 0.146, 0.01981, 0.173, 0.15587, 0.187, 0.17673, 60.61, 2.06217, 87.72),
     "H. H. Li, J. Phys. Chem. Ref. Data 5 (1976), 329"),
    ("sapphire", "Al2O3", (0.2, 5.0), 0.0, (1.4313493, 0.0726631, 0.65054713, 0.1193242, 5.3414021, 18.028251),
     "I. H. Malitson and M. J. Dodge 1972, in Handbook of Laser Science and Technology IV 2 (1986); the ordinary ray"),
    ("diamond", "C", (0.226, 0.76), 0.0, (0.3306, 0.175, 4.3356, 0.106), "F. Peter, Z. Phys. 15 (1923), 358"),
    ("silicon", "Si", (1.357, 11.04), 0.0, (10.6684293, 0.301516485, 0.0030434748, 1.13475115, 1.54133408, 1104.0),
     "C. D. Salzberg and J. J. Villa, J. Opt. Soc. Am. 47 (1957), 244; B. Tatian, Appl. Opt. 23 (1984), 4477"),
    ("zinc selenide", "ZnSe", (0.54, 18.2), 0.0,
     (4.45813734, 0.200859853, 0.467216334, 0.391371166, 2.89566290, 47.1362108),
     "J. Connolly and others, Proc. SPIE 181 (1979), 141; B. Tatian, Appl. Opt. 23 (1984), 4477"),
    ("gallium arsenide", "GaAs", (0.97, 17.0), 4.372514,
     (5.466742, 0.4431307, 0.0242996, 0.8746453, 1.957522, 36.9166),
     "T. Skauli and others, J. Appl. Phys. 94 (2003), 6447"),
)  # fmt: skip
"""Name, formula, range, a, and (b, resonance in μm) of each term, source."""

_POLYMERS = "N. Sultanova and others, Acta Physica Polonica A 116 (2009), 585; 20 °C"
_OTHERS: tuple[tuple[str, str | None, Made], ...] = (
    ("water", "H2O", lambda: Sellmeier(
        (0.5684027565, 0.1726177391, 0.02086189578, 0.1130748688),
        (0.005101829712, 0.01821153936, 0.02620722293, 10.69792721), 0.0, (0.182, 1.129), "water",
        "M. Daimon and A. Masumura, Appl. Opt. 46 (2007), 3811; distilled, 20 °C")),
    ("air", None, lambda: Edlen(
        (0.05792105, 0.00167917), (238.0185, 57.362), (0.23, 1.69), "air",
        "P. E. Ciddor, Appl. Opt. 35 (1996), 1566; dry, 15 °C, 101.325 kPa, 450 ppm CO2")),
    ("germanium", "Ge", lambda: Sellmeier(
        (0.4886331, 14.5142535, 0.0091224), (1.393959, 0.1626427, 752.19), 0.0, (2.0, 14.0), "germanium",
        "J. H. Burnett and others, Proc. SPIE 9974 (2016), 99740X; 22 °C")),
    ("PMMA", None, lambda: Sellmeier((1.1819,), (0.011313,), 0.0, (0.4368, 1.052), "PMMA", _POLYMERS)),
    ("polycarbonate", None,
     lambda: Sellmeier((1.4182,), (0.021304,), 0.0, (0.4368, 1.052), "polycarbonate", _POLYMERS)),
    ("polystyrene", None, lambda: Sellmeier((1.4435,), (0.020216,), 0.0, (0.4368, 1.052), "polystyrene", _POLYMERS)),
    ("gold", "Au", lambda: _metal("gold")),
    ("silver", "Ag", lambda: _metal("silver")),
    ("copper", "Cu", lambda: _metal("copper")),
    ("aluminium", "Al", lambda: _metal("aluminium")),
)  # fmt: skip


def _metal(name: str) -> Dispersion:
    """A metal by its table."""
    from .glass_tables import metals

    rows = [tuple(map(float, item.split())) for item in getattr(metals, name.upper()).replace("\n", ";").split(";")]
    w, n, k = zip(*(row for row in rows if row), strict=True)
    source = "A. D. Rakić, Appl. Opt. 34 (1995), 4755" if name == "aluminium" else (
        "P. B. Johnson and R. W. Christy, Phys. Rev. B 6 (1972), 4370")  # fmt: skip
    return Tabulated(w, n, k, name, source)


def _crystal(name: str, span: tuple[float, float], a: float, terms: tuple[float, ...], source: str) -> Made:
    return lambda: Sellmeier(terms[::2], tuple(w * w for w in terms[1::2]), a, span, name, source)


def _glass(line: str, source: str) -> tuple[str, Made]:
    """A line of a maker's table."""
    name, formula, low, high, *rest = line.split()
    span, values = (float(low), float(high)), tuple(map(float, rest))
    if formula == "S":
        return name, lambda: Sellmeier(values[::2], values[1::2], 0.0, span, name, source)
    return name, lambda: Schott(values, span, name, source)


class Glasses(Mapping[str, Dispersion]):
    """Published refractive indices by name: `glasses["N-BK7"]`; crystals and metals by their formulas as well.

    Each has `name`, `source`, `range` and, within the visible, `n_d` and `abbe_number`.
    Raises KeyError for a name that there is not, with the one most like it.
    """

    @cached_property
    def _made(self) -> dict[str, Made]:
        from .glass_tables import makers, schott

        tables = (
            (schott.SCHOTT, "Schott, catalogue of 2017-01-20"), (makers.OHARA, "Ohara, catalogue of 2017-11-30"),
            (makers.CDGM, "CDGM, catalogue of 2022-06"), (makers.HOYA, "Hoya, catalogue of 2017-04-01"),
        )  # fmt: skip
        found = dict(_glass(line, source) for text, source in tables for line in text.strip().split("\n"))
        for name, formula, span, a, terms, source in _CRYSTALS:
            found[name] = found[formula] = _crystal(name, span, a, terms, source)
        for name, other, make in _OTHERS:
            found |= {name: make} if other is None else {name: make, other: make}
        return found

    @cached_property
    def _known(self) -> dict[str, Dispersion]:
        return {}

    def __getitem__(self, name: str) -> Dispersion:
        if name not in self._known:
            if not isinstance(name, str) or name not in self._made:
                close = close_to(name, list(self._made)) if isinstance(name, str) else ""
                raise KeyError(f"there is no {shown(name)}{f' (did you mean {close!r}?)' if close else ''}")
            self._known[name] = self._made[name]()
        return self._known[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._made)

    def __len__(self) -> int:
        return len(self._made)

    def __contains__(self, name: object) -> bool:
        return name in self._made

    def __repr__(self) -> str:
        return f"Glasses({len(self)} by name)"

    def __reduce__(self) -> Any:
        return "glasses"


glasses = Glasses()


def glass(name: str) -> Dispersion:
    """The published index of a glass, crystal, liquid, plastic or metal: `glasses[name]`.

    name: as makers write it, such as "N-BK7" or "S-FPL53", or "water"; list(co.optics.glasses) are all.
    Raises ValueError for a name that there is not.
    """
    if isinstance(name, str) and name in glasses:
        return glasses[name]
    raise ValueError(f"glass: name must be one of co.optics.glasses, got {shown(name)}{close_glass(name)}")


def close_glass(name: object) -> str:
    """What glass may be meant by a name that there is not."""
    if not isinstance(name, str):
        return ""
    newer = [f"{first}{name}" for first in ("N-", "S-", "H-") if f"{first}{name}" in glasses]
    close = newer[0] if newer else close_to(name, list(glasses))
    return f"; {close!r} is a glass of the catalogue, co.optics.glasses" if close else ""
