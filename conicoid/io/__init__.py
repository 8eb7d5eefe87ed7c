"""Files: scene files, files of other programs, rays and results, images and movies."""
