"""A valve of one Boolean body, a poppet and a spring seat, sliced: arcs, hyperbolas and lines as SVG and PDF."""

from __future__ import annotations

import conicoid as co


def housing() -> co.Solid:
    """A bored block with a conical seat, a dished floor and a port from the side."""
    block = co.Box((-4, -3, -3), (4, 3, 3)) | co.Cylinder((4, 0, 0), (6, 0, 0), 1.8)
    chamber = co.Cylinder((0, 0, -1), (0, 0, 4), 2) | co.Cone((0, 0, -2), (0, 0, -1), 1, 2)
    dish = co.EllipticParaboloid(0.5, 0.5, (0, 3)).rotate((1, 0, 0), 180).translate((0, 0, -1.8))
    port = co.Cylinder((0, 0, 0), (7, 0, 0), 1.1) | co.Cone((5, 0, 0), (6, 0, 0), 1.1, 1.5)
    groove = co.OneSheetHyperboloid(1 / 2.2**2, 1 / 2.2**2, 0.5, (-0.7, 0.7)).translate((0, 0, 2))
    return block - chamber - dish - port - groove


def scene() -> co.Scene:
    """The housing with its contents."""
    poppet = co.Cone((0, 0, -1.75), (0, 0, -0.75), 1.25, 2) & co.Sphere(2.2, (0, 0, -0.6))
    stem = co.Cylinder((0, 0, -1.2), (0, 0, 2.8), 0.35) | co.Ellipsoid((0.8, 0.8, 0.3), (0, 0, 2.8))
    return co.Scene([
        co.Body(stem, co.matte("#c9a227", name="brass"), name="stem"),
        co.Body(poppet, co.matte("#b5563c", name="bronze"), name="poppet"),
        co.Body(housing(), co.matte("#9aa5b1", name="steel"), name="housing"),
    ])  # fmt: skip


def cut(pixels: int = 640) -> co.section.Slice:
    """An oblique plane, a little beside the middle: circles and paraboloids become ellipses, the groove hyperbolas."""
    return scene().slice(origin=(-4.5, -0.5, -3.4), u=(11, 0, 0), v=(0, 1.2, 6.8), pixels=pixels)


if __name__ == "__main__":
    for name in ("valve_slice.png", "valve_slice.svg", "valve_slice.pdf"):
        cut().save(name, by="material")
