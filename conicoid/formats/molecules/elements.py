"""The elements: symbols, radii of bonds and of van der Waals, and the usual colours.

Covalent radii in Å: B. Cordero and others, "Covalent radii revisited", Dalton Transactions (2008), 2832; for C that of
sp3, for Mn, Fe and Co that of low spin. Radii of van der Waals in Å: S. Alvarez, "A cartography of the van der Waals
territories", Dalton Transactions 42 (2013), 8617. Colours: those of Jmol, which go back to Corey, Pauling and Koltun.
"""

from __future__ import annotations

import numpy as np

from ...shapes.vector import FloatArray

# Symbol, covalent radius, radius of van der Waals, colour; - where nothing is published
_ROWS = """
H 0.31 1.20 ffffff; He 0.28 1.43 d9ffff; Li 1.28 2.12 cc80ff; Be 0.96 1.98 c2ff00; B 0.84 1.91 ffb5b5;
C 0.76 1.77 909090; N 0.71 1.66 3050f8; O 0.66 1.50 ff0d0d; F 0.57 1.46 90e050; Ne 0.58 1.58 b3e3f5;
Na 1.66 2.50 ab5cf2; Mg 1.41 2.51 8aff00; Al 1.21 2.25 bfa6a6; Si 1.11 2.19 f0c8a0; P 1.07 1.90 ff8000;
S 1.05 1.89 ffff30; Cl 1.02 1.82 1ff01f; Ar 1.06 1.83 80d1e3; K 2.03 2.73 8f40d4; Ca 1.76 2.62 3dff00;
Sc 1.70 2.58 e6e6e6; Ti 1.60 2.46 bfc2c7; V 1.53 2.42 a6a6ab; Cr 1.39 2.45 8a99c7; Mn 1.39 2.45 9c7ac7;
Fe 1.32 2.44 e06633; Co 1.26 2.40 f090a0; Ni 1.24 2.40 50d050; Cu 1.32 2.38 c88033; Zn 1.22 2.39 7d80b0;
Ga 1.22 2.32 c28f8f; Ge 1.20 2.29 668f8f; As 1.19 1.88 bd80e3; Se 1.20 1.82 ffa100; Br 1.20 1.86 a62929;
Kr 1.16 2.25 5cb8d1; Rb 2.20 3.21 702eb0; Sr 1.95 2.84 00ff00; Y 1.90 2.75 94ffff; Zr 1.75 2.52 94e0e0;
Nb 1.64 2.56 73c2c9; Mo 1.54 2.45 54b5b5; Tc 1.47 2.44 3b9e9e; Ru 1.46 2.46 248f8f; Rh 1.42 2.44 0a7d8c;
Pd 1.39 2.15 006985; Ag 1.45 2.53 c0c0c0; Cd 1.44 2.49 ffd98f; In 1.42 2.43 a67573; Sn 1.39 2.42 668080;
Sb 1.39 2.47 9e63b5; Te 1.38 1.99 d47a00; I 1.39 2.04 940094; Xe 1.40 2.06 429eb0; Cs 2.44 3.48 57178f;
Ba 2.15 3.03 00c900; La 2.07 2.98 70d4ff; Ce 2.04 2.88 ffffc7; Pr 2.03 2.92 d9ffc7; Nd 2.01 2.95 c7ffc7;
Pm 1.99 - a3ffc7; Sm 1.98 2.90 8fffc7; Eu 1.98 2.87 61ffc7; Gd 1.96 2.83 45ffc7; Tb 1.94 2.79 30ffc7;
Dy 1.92 2.87 1fffc7; Ho 1.92 2.81 00ff9c; Er 1.89 2.83 00e675; Tm 1.90 2.79 00d452; Yb 1.87 2.80 00bf38;
Lu 1.87 2.74 00ab24; Hf 1.75 2.63 4dc2ff; Ta 1.70 2.53 4da6ff; W 1.62 2.57 2194d6; Re 1.51 2.49 267dab;
Os 1.44 2.48 266696; Ir 1.41 2.41 175487; Pt 1.36 2.29 d0d0e0; Au 1.36 2.32 ffd123; Hg 1.32 2.45 b8b8d0;
Tl 1.45 2.47 a6544d; Pb 1.46 2.60 575961; Bi 1.48 2.54 9e4fb5; Po 1.40 - ab5c00; At 1.50 - 754f45;
Rn 1.50 - 428296; Fr 2.60 - 420066; Ra 2.21 - 007d00; Ac 2.15 2.80 70abfa; Th 2.06 2.93 00baff;
Pa 2.00 2.88 00a1ff; U 1.96 2.71 008fff; Np 1.90 2.82 0080ff; Pu 1.87 2.81 006bff; Am 1.80 2.83 545cf2;
Cm 1.69 3.05 785ce3; Bk - 3.40 8a4fe3; Cf - 3.05 a136d4; Es - 2.70 b31fd4; Fm - - b31fba; Md - - b30da6;
No - - bd0d87; Lr - - c70066; Rf - - cc0059; Db - - d1004f; Sg - - d90045; Bh - - e00038; Hs - - e6002e;
Mt - - eb0026; Ds - - -; Rg - - -; Cn - - -; Nh - - -; Fl - - -; Mc - - -; Lv - - -; Ts - - -; Og - - -
"""
_TABLE = [row.split() for row in _ROWS.replace("\n", " ").split(";")]

SYMBOLS = ("X", *(row[0] for row in _TABLE))
"""By atomic number; 0 is an atom of no known element."""
_NUMBERS = {symbol.upper(): number for number, symbol in enumerate(SYMBOLS)} | {"D": 1, "T": 1}


def _column(at: int, otherwise: float) -> FloatArray:
    values = np.array([otherwise] + [otherwise if row[at] == "-" else float(row[at]) for row in _TABLE])
    values.flags.writeable = False
    return values


COVALENT = _column(1, 1.5)
"""By atomic number, in Å; 1.5 where nothing is published."""
VAN_DER_WAALS = _column(2, 2.0)
"""By atomic number, in Å; 2 where nothing is published."""
COLORS = ("#ff1493", *("#ff1493" if row[3] == "-" else f"#{row[3]}" for row in _TABLE))
"""By atomic number; pink where none is usual."""


def number_of(symbol: str) -> int | None:
    """The atomic number of a symbol in any letters, also with an isotope or a charge ("FE2+", "13C"); None if unknown.

    D and T are hydrogen, X is 0.
    """
    return _NUMBERS.get(symbol.strip().lstrip("0123456789").rstrip("0123456789+-").upper())
