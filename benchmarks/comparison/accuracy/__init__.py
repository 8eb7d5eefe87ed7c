"""`python -m benchmarks --accuracy`: distances of Conicoid and its peers against exact integers."""
