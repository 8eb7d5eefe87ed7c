"""The tests: the package's own tree, and the proofs (`reference`, `exactness`, `contract`, `seeds`)."""
