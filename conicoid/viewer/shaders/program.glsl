// Boolean programs as counting gates. A gate is true when at least `need` inputs are.

int counts[GATES];
int first_gate;

void start_gates(int first, int last) {
    first_gate = first;
    for (int gate = first; gate < last; gate++) counts[gate - first] = integer4(GATE, gate).w;
}

bool root_value() {
    ivec4 root = integer4(GATE, first_gate);
    return (counts[0] >= root.y) != (root.z == 1);
}

// Count a leaf's change up to the first gate that keeps its value
void turn_leaf(ivec4 leaf, bool on) {
    int gate = leaf.y;
    bool rises = on != (leaf.z == 1);
    while (gate >= 0) {
        ivec4 row = integer4(GATE, gate);
        int count = counts[gate - first_gate];
        bool before = count >= row.y;
        count += rises ? 1 : -1;
        counts[gate - first_gate] = count;
        bool after = count >= row.y;
        if (before == after) return;
        rises = after != (row.z == 1);
        gate = row.x;
    }
}

// Does every gate from a leaf to the root have the value that the leaf, inside (`on`) or outside, alone gives?
bool leaf_decides(ivec4 leaf, bool on) {
    int gate = leaf.y;
    bool rises = on != (leaf.z == 1);
    while (gate >= 0) {
        ivec4 row = integer4(GATE, gate);
        if ((counts[gate - first_gate] >= row.y) != rises) return false;
        rises = rises != (row.z == 1);
        gate = row.x;
    }
    return true;
}
