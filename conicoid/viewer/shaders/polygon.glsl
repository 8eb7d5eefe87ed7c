// Is a ray inside a closed loop of points, by even-odd?
// u and v of a vertex depend on the ray and the vertex alone, so neighbours see one and the same edge.

vec2 seen_along(int axis, vec3 vertex, Ray ray) {
    vec3 x = vertex - ray.o, d = ray.d;
    if (axis == 0) { x = x.yzx; d = d.yzx; }
    else if (axis == 1) { x = x.zxy; d = d.zxy; }
    return vec2(d.z * x.x - d.x * x.z, d.z * x.y - d.y * x.z);
}

bool inside_loop(int first, int last, Ray ray) {
    vec3 d = abs(ray.d);
    int axis = d.z >= d.x && d.z >= d.y ? 2 : (d.x >= d.y ? 0 : 1);
    bool odd = false;
    vec2 a = seen_along(axis, real4(u_vertices + last - 1).xyz, ray);
    for (int k = first; k < last; k++) {
        vec2 b = seen_along(axis, real4(u_vertices + k).xyz, ray);
        if ((a.y < 0.0) != (b.y < 0.0)) {
            // Upward always, so that both neighbours round alike, whatever a driver fuses
            vec2 low = b.y > a.y ? a : b, high = b.y > a.y ? b : a;
            if (low.x * high.y - high.x * low.y > 0.0) odd = !odd;
        }
        a = b;
    }
    return odd;
}
