"""Import of OpenSCAD's evaluated models, .csg files. See docs/openscad.md."""
