// Walking a tree of boxes along a ray: conicoid/engine/tree/walk.py. One stack serves the scene's tree and,
// above what that has left waiting, the tree over the leaves of a body.

int stack_code[STACK];
float stack_t[STACK];
int stack_top;

vec3 reciprocal(vec3 d) {
    return vec3(abs(d.x) > 1e-20 ? 1.0 / d.x : (d.x < 0.0 ? -1e20 : 1e20),
                abs(d.y) > 1e-20 ? 1.0 / d.y : (d.y < 0.0 ? -1e20 : 1e20),
                abs(d.z) > 1e-20 ? 1.0 / d.z : (d.z < 0.0 ? -1e20 : 1e20));
}

void push_one(float t, int code, int base) {
    int slot = stack_top++;
    for (; slot > base && stack_t[slot - 1] < t; slot--) {
        stack_t[slot] = stack_t[slot - 1];
        stack_code[slot] = stack_code[slot - 1];
    }
    stack_t[slot] = t;
    stack_code[slot] = code;
}

// Put the children of a node that the ray meets in [first, last] on the stack, the nearest on top
void push_node(int node, Ray ray, vec3 inverse, float first, float last) {
    int base = stack_top;
    for (int half_node = 0; half_node < 2; half_node++) {
        int at = u_boxes + 12 * node + half_node;
        vec4 near = vec4(first), far = vec4(last);
        for (int axis = 0; axis < 3; axis++) {
            vec4 a = (real4(at + 2 * axis) - ray.o[axis]) * inverse[axis];
            vec4 b = (real4(at + 2 * axis + 6) - ray.o[axis]) * inverse[axis];
            near = max(near, min(a, b));
            far = min(far, max(a, b));
        }
        ivec4 child = integer4(CHILDREN, 2 * node + half_node);
        for (int i = 0; i < 4; i++)
            if (child[i] != 0 && near[i] <= far[i] + abs(far[i]) * 1e-6) push_one(near[i], child[i], base);
    }
}

// Start a walk: what no box holds is on top
void push_roots(int tree) {
    ivec4 range = integer4(ROOTS, tree);
    for (int k = range.x; k < range.y; k++) {
        stack_t[stack_top] = -FAR;
        stack_code[stack_top++] = record(u_root_list + k).x;
    }
}

// (first, last) places in ORDER of a leaf
ivec2 leaf_range(int code) {
    int first = (-code - 1) >> 4;
    return ivec2(first, first + ((-code - 1) & 15));
}
