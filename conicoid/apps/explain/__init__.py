"""One ray worked out as on a blackboard: `scene.explain`, and what a surface of a scene is: `scene.surface`.

The numbers are the kernels' own (`ray_records.py`); the lecture's, beside them, come from exact arithmetic
and are rounded once.
"""
