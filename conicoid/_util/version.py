"""The version of the package, which must equal `version` in pyproject.toml."""

__version__ = "0.1.0"
