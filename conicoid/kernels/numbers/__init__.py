"""Numbers: vectors of three, error-free operations, pairs of floats, numbers with a bound on their error."""
