"""Number types of kernels: vectors of three, error-free operations, pairs and quads of floats with error bounds."""
