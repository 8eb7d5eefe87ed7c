"""The tests: the package's own tree, and the proofs (`oracle`, `contract`, `seeds`, `adversarial`)."""
