"""`conicoid bench`: the same rays through Conicoid and through every peer that is installed."""
