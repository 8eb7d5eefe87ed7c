"""From shapes to the tables and the tree that kernels read."""
