"""Published prescriptions of lenses, with the focal lengths that their sources print.

Rows: radius, thickness, refractive index behind it (1 is air, "mirror" reflects), and for conics the constant.
"""

import math
from dataclasses import dataclass, field
from typing import Any

INF = math.inf


@dataclass(frozen=True)
class Published:
    rows: tuple[tuple[Any, ...], ...]
    aperture: float
    source: str
    printed: dict[str, str] = field(default_factory=dict)
    """efl, bfl (from the last vertex), ffl (from the first), with the printed digits (nine at most)."""
    stop: int = 0
    rounded: float = 0.0
    """Half the last digit of the indices, which may differ so much from those of the source's own computation."""


LENSES = {
    "double Gauss f/2": Published(
        ((56.20238, 8.75, 1.622292), (152.2858, 0.5, 1), (37.68262, 12.5, 1.607379), (INF, 3.8, 1.603417), (24.2313, 16.369445, 1),
         (INF, 13.747957, 1), (-28.37731, 3.8, 1.603417), (INF, 11, 1.620408), (-37.92546, 0.5, 1), (177.41176, 7, 1.620408), (-79.41143, 61.487536, 1)),
        50, "CODE V's listing of its sample, in ray-optics: codev/tests/ag_dblgauss.lis", {"efl": "100.0038", "bfl": "61.4875", "ffl": "-29.3208"}, 5, 5e-7),
    "Sasian triplet": Published(
        ((23.713, 4.831, 1.69100), (7331.288, 5.86, 1), (-24.456, 0.975, 1.67271), (21.896, 4.822, 1), (86.759, 3.127, 1.69100), (-20.4942, 41.2365, 1)),
        12.5, "ray-optics' documentation, after Sasian; N-LAK9 and N-SF5 at the line d by Schott", {"efl": "50.00", "bfl": "41.24", "ffl": "-37.1"}, 2),
    "Edmund 32-327": Published(
        ((61.47, 6, 1.51680), (-44.64, 2.5, 1.67271), (-129.94, 95.9519, 1)),
        25, "Edmund's achromat in ray-optics' documentation; N-BK7 and N-SF5 by Schott", {"efl": "100.0", "bfl": "95.95", "ffl": "-98.58"}),
    "Cooke triplet": Published(
        ((22.01359, 3.25896, 1.6226085614386923), (-435.76044, 6.00755, 1), (-22.21328, 0.99997, 1.6236551229276037), (20.29192, 4.75041, 1),
         (79.6836, 2.95208, 1.6226085614386923), (-18.39533, 42.20778, 1)),
        10, "Zemax's sample, in Optiland's samples; SK16 and F2 at 0.55 μm", {"efl": "50.00"}, 3),
    "Loewenthal's double Gauss": Published(
        ((85.5, 11.6, 1.74400), (408.33, 1.5, 1), (40.35, 17, 1.62041), (156.05, 3.5, 1.62096), (25.05, 13.7, 1), (INF, 8.3, 1), (-36.8, 3.5, 1.68893),
         (55, 23, 1.74400), (-51.5, 1, 1), (123.5, 17, 1.74400), (-204.96, 55.066, 1)),
        60, "USP 2,601,805, in Smith, Modern Lens Design (1992), p. 305; Schott's indices", {"efl": "100.4", "bfl": "55.07"}, 5),
    "Werfel's double Gauss": Published(
        ((93.32, 11.32, 1.71700), (358.29, 0.4, 1), (46.32, 20, 1.64328), (INF, 2, 1.58921), (28.68, 14, 1), (INF, 10, 1), (-41.32, 6, 1.76182),
         (60.8, 22, 1.74400), (-55, 13, 1), (90.2, 16, 1.71700), (-212.58, 56.424, 1)),
        60, "USP 2,771,006, in Smith, Modern Lens Design (1992), p. 304; Schott's indices", {"efl": "100.1", "bfl": "56.42"}, 5),
    "Fraunhofer objective": Published(
        ((17.654, 1.4, 1.51680), (53.898, 0.1, 1), (16.53, 0.6, 1.71736), (13.075, 94.931, 1)),
        14, "Smith, Modern Lens Design (1992), p. 66; Schott's indices", {"bfl": "94.93"}),
    "fast double Gauss": Published(
        ((56.655, 5.24, 1.815), (600, 0.565, 1), (25.68, 6.56, 1.694), (51.875, 0.8, 1), (84.6, 2.255, 1.63003), (17.295, 5.865, 1), (INF, 5.565, 1),
         (-19.475, 2.855, 1.7918), (246.02, 6.185, 1.8004), (-35.965, 0.095, 1), (-125.895, 4.05, 1.8004), (-37.625, 0.095, 1), (198.13, 4.05, 1.71615),
         (-63.025, 36.5, 1)),
        35, "US patent 3,552,829, example 1, scaled to f = 50", {"efl": "50.0"}, 6),
    "Heliar": Published(
        ((4.2103, 0.9004, 1.620409965080894), (-3.6208, 0.2999, 1.5317170107238276), (29.1869, 0.7587, 1), (-3.1715, 0.2, 1.5317170107238276),
         (3.2083, 0.1264, 1), (INF, 0.2629, 1), (43.071, 0.25, 1.5317170107238276), (2.4494, 0.8308, 1.620409965080894), (-3.2576, 8.5066, 1)),
        2, "Laikin, Lens Design (2007), p. 63, in Optiland's samples and their tests", {"efl": "10.0065293"}, 5),
    "telephoto": Published(
        ((21.81606, 6.07314, 1.5168000345005885), (-68.33108, 2.286, 1.6644601934840138), (77.00772, 1.22174, 1), (INF, 26.28138, 1),
         (-14.5161, 2.286, 1.5084693280849817), (-18.85442, 2.5527, 1.7858245578889926), (-29.03982, 0.39624, 1), (-432.78552, 2.01422, 1.7173598484766892),
         (-70.3453, 62.98184, 1)),
        22, "Laikin, Lens Design (2007), p. 91, in Optiland's samples and their tests", {"efl": "127.016601"}, 3),
    "Hubble telescope": Published(
        ((-11040, -4906.071, "mirror", -1.0022985), (-1358, 6406.2, "mirror", -1.496)),
        2400, "Sinclair Optics' OSLO sample hubble.len; the focal length is NASA's, 57.6 m", {"efl": "576E2"}),
    "Hubble telescope after Laikin": Published(
        ((-11040.02286, -4910.01016, "mirror", -1.001152), (-1349.31166, 6365.20955, "mirror", -1.483014)),
        2400, "Laikin, Lens Design (2007), p. 200, in Optiland's samples and their tests", {"efl": "57600.0810"}),
    "Cassegrain f/4": Published(
        ((-1 / 2.187226596675415774e-2, -16, "mirror", -1.0), (-1 / 5.208333333333333565e-2, 24.035, "mirror", -3.236)),
        20, "Handbook of Optics II (1995), chapter 18, in ray-optics' tests", {"bfl": "24.035"}),
}  # fmt: skip
