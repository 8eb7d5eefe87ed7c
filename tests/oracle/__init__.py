"""An independent reference: what a ray does to a solid, in 90 digits, from the user's parameters alone.

Nothing here imports the library. A solid is a Boolean formula over polynomial inequalities of
degree two at most; a ray turns each polynomial into a quadratic in t; roots are sorted and the
formula is asked between them. See `trace.py` for the statement of the tangency band.
"""
