"""Numbers in plain Python: 3000-bit floats, rational linear algebra, portable elementary functions."""
