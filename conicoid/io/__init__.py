"""One file per format: scene files and what they are made of, rays and hits, PNG, OpenEXR."""
