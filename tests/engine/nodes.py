"""A scene's trees, read from its tables: where each entry stands, and how many nodes a point visits."""

import math

import numpy as np

from conicoid.kernels import tables as table


class Nodes:
    """The scene's tree, read from its tables as `tables.py` documents them."""

    def __init__(self, scene):
        geometry = scene._prepared.geometry

        def part(k, numbers):
            first, size = geometry.places[k], geometry.places[table.LENGTHS + k]
            return numbers[first : first + size]

        ends = part(table.TREE_ROOT, geometry.integers)
        self.boxes = part(table.NODE_BOXES, geometry.floats).reshape(-1, 6, 8)
        self.children = part(table.NODE_CHILDREN, geometry.integers).reshape(-1, 8)
        self.order = part(table.TREE_ORDER, geometry.integers)
        self.roots = part(table.ROOTS, geometry.integers)[ends[-2] : ends[-1]].tolist()
        self.depth = int(part(table.TREE_DEPTH, geometry.integers)[0])
        self.extent = part(table.EXTENT, geometry.floats)
        self.entries = scene._prepared.lowered.boxes

    def leaf(self, code):
        first, count = (-code - 1) >> 4, (-code - 1) & 15
        return self.order[first : first + count].tolist()

    def slots(self, node):
        return [k for k in range(8) if self.children[node, k] != 0]

    def beside(self):
        return [entry for root in self.roots if root < 0 for entry in self.leaf(root)]

    def check(self):
        """Check that every entry is in one leaf and boxes lie in boxes, and the height of a stack."""
        found, highest = self.beside(), len(self.roots)
        pending = [(root, None, len(self.roots)) for root in self.roots if root >= 0]
        while pending:
            node, around, height = pending.pop()
            slots = self.slots(node)
            assert slots, "a node without children"
            highest = max(highest, height - 1 + len(slots))
            for k in range(8):
                box, code = self.boxes[node, :, k], self.children[node, k]
                if code == 0:
                    assert (box == [math.inf] * 3 + [-math.inf] * 3).all()
                    continue
                if around is not None:
                    assert (around[:3] <= box[:3]).all()
                    assert (around[3:] >= box[3:]).all()
                if code > 0:
                    pending.append((code, box, height - 1 + len(slots)))
                    continue
                entries = self.leaf(code)
                found += entries
                assert (self.entries[entries, :3] >= box[:3]).all()
                assert (self.entries[entries, 3:] <= box[3:]).all()
        empty = (self.entries[:, :3] > self.entries[:, 3:]).any(axis=1)
        assert sorted(found) == np.flatnonzero(~empty).tolist()
        assert highest <= self.depth
        assert np.isfinite(self.extent[[0, 2, 3, 4]]).all()

    def visits(self, point):
        """Return the number of nodes that hold a point or are roots."""
        pending, count = [root for root in self.roots if root >= 0], 0
        while pending:
            node = pending.pop()
            count += 1
            low, high = self.boxes[node, :3], self.boxes[node, 3:]
            inside = ((low <= point[:, None]) & (point[:, None] <= high)).all(axis=0)
            pending += [self.children[node, k] for k in self.slots(node) if inside[k] and self.children[node, k] > 0]
        return count
