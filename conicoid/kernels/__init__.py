"""The engine: from the tables of a lowered scene and arrays of rays to certified answers."""
