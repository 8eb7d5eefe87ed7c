"""Published refractive indices, as text."""
