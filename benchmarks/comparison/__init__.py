"""The same rays through Conicoid and through every peer that is installed (`python -m benchmarks`)."""
