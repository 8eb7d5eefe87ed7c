"""Find the volume of a GDML file at each point: plain NumPy, in floats, from the XML alone, independent of Conicoid.

It reads files of plain numbers: boxes, tubes, cones, spheres, trds, traps, polycones, Booleans, placements.
"""

import itertools
import xml.etree.ElementTree as ElementTree

import numpy as np

UNITS = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "rad": 1.0, "radian": 1.0, "deg": np.pi / 180, "degree": np.pi / 180}


def rotation(x, y, z):
    """Return Rz Ry Rx."""
    (a, b, c), (d, e, f) = np.cos([x, y, z]), np.sin([x, y, z])
    rx = np.array([[1, 0, 0], [0, a, -d], [0, d, a]])
    ry = np.array([[b, 0, e], [0, 1, 0], [-e, 0, b]])
    rz = np.array([[c, -f, 0], [f, c, 0], [0, 0, 1]])
    return rz @ ry @ rx


class Evaluator:
    """One file. `deepest(points)` gives the name of the volume (its definition) at each point, "" for none."""

    def __init__(self, path):
        self.root = ElementTree.parse(path).getroot()
        self.solids = {one.get("name"): one for one in self.root.find("solids")}
        self.volumes = {one.get("name"): one for one in self.root.find("structure")}
        define = self.root.find("define")
        self.named = {} if define is None else {one.get("name"): one for one in define}
        self.world = self.root.find("setup").find("world").get("ref")

    def vector(self, parent, name):
        ref, own = parent.find(name + "ref"), parent.find(name)
        one = self.named[ref.get("ref")] if ref is not None else own
        if one is None:
            return np.zeros(3)
        unit = UNITS[one.get("unit") or ("rad" if "rotation" in name else "mm")]
        return unit * np.array([float(one.get(axis, 0)) for axis in "xyz"])

    def inside(self, name, p):
        s = self.solids[name]
        length, angle = UNITS[s.get("lunit") or "mm"], UNITS[s.get("aunit") or "rad"]
        x, y, z = p.T
        r = np.hypot(x, y)

        def size(key, default=0.0):
            return length * float(s.get(key, default))

        def phi():
            start, delta = (angle * float(s.get(key, value)) for key, value in (("startphi", 0), ("deltaphi", 7)))
            return (np.arctan2(y, x) - start) % (2 * np.pi) <= delta

        def stack(planes):
            found = np.zeros(len(p), bool)
            for (z0, a, b), (z1, c, d) in itertools.pairwise(planes):
                if z0 != z1:
                    t = (z - z0) / (z1 - z0)
                    found |= (t >= 0) & (t <= 1) & (r >= a + (c - a) * t) & (r <= b + (d - b) * t)
            return found & phi()

        match s.tag:
            case "box":
                return (abs(x) <= size("x") / 2) & (abs(y) <= size("y") / 2) & (abs(z) <= size("z") / 2)
            case "tube":
                h = size("z") / 2
                return stack([(-h, size("rmin"), size("rmax")), (h, size("rmin"), size("rmax"))])
            case "cone":
                h = size("z") / 2
                return stack([(-h, size("rmin1"), size("rmax1")), (h, size("rmin2"), size("rmax2"))])
            case "polycone":
                return stack([[length * float(one.get(key, 0)) for key in ("z", "rmin", "rmax")] for one in s])
            case "orb":
                return np.linalg.norm(p, axis=1) <= size("r")
            case "sphere":
                d = np.linalg.norm(p, axis=1)
                theta = np.arccos(z / d)
                low, more = (angle * float(s.get(key, value)) for key, value in (("starttheta", 0), ("deltatheta", 4)))
                return (d >= size("rmin")) & (d <= size("rmax")) & phi() & (theta >= low) & (theta <= low + more)
            case "trd" | "trap":
                return self.trapezoid(s, size, angle, x, y, z)
            case "union" | "subtraction" | "intersection":
                first, second = (
                    self.inside(
                        s.find(tag).get("ref"),
                        (p - self.vector(s, before + "position")) @ rotation(*self.vector(s, before + "rotation")),
                    )
                    for tag, before in (("first", "first"), ("second", ""))
                )
                return first | second if s.tag == "union" else first & (second ^ (s.tag == "subtraction"))
        raise NotImplementedError(s.tag)

    def trapezoid(self, s, size, angle, x, y, z):
        h = size("z") / 2
        t = (z + h) / (2 * h)

        def between(low, high):
            return low + (high - low) * t

        if s.tag == "trd":
            return (
                (t >= 0)
                & (t <= 1)
                & (abs(x) <= between(size("x1"), size("x2")) / 2)
                & (abs(y) <= between(size("y1"), size("y2")) / 2)
            )
        theta, phi, one, two = (angle * float(s.get(key)) for key in ("theta", "phi", "alpha1", "alpha2"))
        y = y - z * np.tan(theta) * np.sin(phi)
        x = x - z * np.tan(theta) * np.cos(phi)
        half = between(size("y1"), size("y2")) / 2
        below, above = between(size("x1"), size("x3")) / 2, between(size("x2"), size("x4")) / 2
        # The middles of the edges at -y and y, linear in z as all corners are
        middle = between(size("y1") / 2 * np.tan(one), size("y2") / 2 * np.tan(two))
        u = y / half
        return (
            (t >= 0) & (t <= 1) & (abs(u) <= 1) & (abs(x - middle * u) <= (below + above) / 2 + (above - below) / 2 * u)
        )

    def deepest(self, points):
        found = np.full(len(points), "", object)
        self.fill(self.world, np.asarray(points, float), np.arange(len(points)), found)
        return found

    def fill(self, name, p, indices, found):
        volume = self.volumes[name]
        if volume.tag == "volume":
            here = self.inside(volume.find("solidref").get("ref"), p)
            p, indices = p[here], indices[here]
            found[indices] = name
        for one in volume.findall("physvol"):
            q = (p - self.vector(one, "position")) @ rotation(*self.vector(one, "rotation")).T
            if len(q):
                self.fill(one.find("volumeref").get("ref"), q, indices, found)
