"""OpenSCAD's evaluated geometry, .csg files, as scenes. See docs/openscad.md."""
