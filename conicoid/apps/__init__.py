"""Applications: optics, tomography, measures, checks, sections, derivatives, explanations."""
