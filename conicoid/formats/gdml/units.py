"""Names that GDML's expressions know without a definition: units, in mm, ns, MeV and radians, and π."""

from __future__ import annotations

from fractions import Fraction

PI = Fraction("3.14159265358979323846264338327950288")
"""So exact that angles which come back from radians are the floats on paper."""

_MM = {
    "fm": "1e-12", "fermi": "1e-12", "angstrom": "1e-7", "Ang": "1e-7", "nm": "1e-6", "nanometer": "1e-6",
    "um": "1e-3", "micrometer": "1e-3", "mm": "1", "millimeter": "1", "cm": "10", "centimeter": "10", "dm": "100",
    "m": "1000", "meter": "1000", "km": "1e6", "kilometer": "1e6", "in": "25.4", "inch": "25.4",
    "mm2": "1", "cm2": "100", "m2": "1e6", "mm3": "1", "cm3": "1000", "m3": "1e9", "L": "1e6", "dL": "1e5", "cL": "1e4",
    "mL": "1e3", "liter": "1e6", "barn": "1e-22",
}  # fmt: skip
_OTHERS = {
    "ns": "1", "nanosecond": "1", "ps": "1e-3", "us": "1e3", "ms": "1e6", "s": "1e9", "second": "1e9", "Hz": "1e-9",
    "kHz": "1e-6", "MHz": "1e-3", "eV": "1e-6", "keV": "1e-3", "MeV": "1", "GeV": "1e3", "TeV": "1e6", "PeV": "1e9",
    "electronvolt": "1e-6", "kiloelectronvolt": "1e-3", "megaelectronvolt": "1", "gigaelectronvolt": "1e3",
    "joule": "6.241509074e12", "J": "6.241509074e12", "kelvin": "1", "K": "1", "mole": "1", "mol": "1", "volt": "1e-6",
    "kilovolt": "1e-3", "megavolt": "1", "tesla": "1e-3", "gauss": "1e-7", "kilogauss": "1e-4", "perCent": "0.01",
    "perThousand": "1e-3", "perMillion": "1e-6", "mg": "1e-3", "milligram": "1e-3", "g": "1", "gram": "1", "kg": "1e3",
    "kilogram": "1e3", "pascal": "1", "Pa": "1", "hPa": "100", "kPa": "1e3", "MPa": "1e6", "bar": "1e5",
    "mbar": "100", "atmosphere": "101325", "atm": "101325", "becquerel": "1e-9", "curie": "37",
}  # fmt: skip
"""Pressures in pascal and masses in grams, since only ratios within each count here."""

NAMES: dict[str, Fraction] = {name: Fraction(value) for name, value in (_MM | _OTHERS).items()} | {
    "rad": Fraction(1), "radian": Fraction(1), "mrad": Fraction(1, 1000), "milliradian": Fraction(1, 1000),
    "deg": PI / 180, "degree": PI / 180, "pi": PI, "PI": PI, "twopi": 2 * PI, "TWOPI": 2 * PI, "halfpi": PI / 2,
    "HALFPI": PI / 2, "pi2": PI * PI, "e": Fraction("2.718281828459045235360287"), "g/cm3": Fraction(1, 1000),
}  # fmt: skip


def in_degrees(radians: Fraction) -> Fraction:
    """An angle in degrees; to the float that it is on paper, where it came through radians in double precision."""
    return Fraction(float(radians * 180 / PI))
