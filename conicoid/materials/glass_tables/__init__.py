"""Tables of published refractive indices, as text."""
