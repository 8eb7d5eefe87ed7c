// A cell on a ray: conicoid/engine/body/cell.py. At most two spans, each end with the place of its face:
// a row of the cells' planes, -2 - cell for its curved face, NO_PLACE at infinity, CUT_PLACE on the section plane.

const int NO_PLACE = -1;
const int CUT_PLACE = 0x7fffffff;

struct Spans {
    int count;
    float in1, out1, in2, out2;
    int a1, b1, a2, b2;
};

// (t, height, rate): where the ray crosses a plane; t = 0 on the plane it starts on
vec3 plane_crossing(int surface, Ray ray) {
    int at = integer4(SURFACE, surface).y;
    vec4 plane = real4(at);
    vec3 anchor = real4(at + 1).xyz;
    float rate = dot(plane.xyz, ray.d);
    float height = surface == ray.start ? 0.0 : dot(plane.xyz, ray.o - anchor) + plane.w;
    return vec3(rate == 0.0 ? FAR : clamp(-height / rate, -FAR, FAR), height, rate);
}

Spans cell_spans(int cell, Ray ray, float inverse) {
    ivec4 row = integer4(CELLS, cell);
    float t_in = -FAR, t_out = FAR;
    int place_in = NO_PLACE, place_out = NO_PLACE, curved = -2 - cell;
    Spans none = Spans(0, FAR, -FAR, FAR, -FAR, NO_PLACE, NO_PLACE, NO_PLACE, NO_PLACE);
    for (int slot = row.z; slot < row.w; slot++) {
        ivec4 face = integer4(SLOTS, slot);
        vec3 crossing = plane_crossing(face.x, ray);
        if (crossing.z == 0.0) {
            if ((crossing.y <= 0.0) != (face.y > 0)) return none;
        } else if ((crossing.z < 0.0) == (face.y > 0)) {
            if (crossing.x > t_in) { t_in = crossing.x; place_in = slot; }
        } else if (crossing.x < t_out) { t_out = crossing.x; place_out = slot; }
    }
    if (!(t_in < t_out)) return none;
    Spans one = Spans(1, t_in, t_out, FAR, -FAR, place_in, place_out, NO_PLACE, NO_PLACE);
    if (row.x < 0) return one;
    Roots roots = curved_roots(row.x, ray, inverse);
    bool outside = roots.outside != ((row.y & 1) == 0);
    if (!roots.crosses) {
        one.count = outside ? 1 : 0;
        return one;
    }
    if (!outside) {
        one.a1 = roots.low >= t_in ? curved : place_in;
        one.b1 = roots.high <= t_out ? curved : place_out;
        one.in1 = max(roots.low, t_in);
        one.out1 = min(roots.high, t_out);
        one.count = one.in1 < one.out1 ? 1 : 0;
        return one;
    }
    // Outside of ]low, high[: what is left of it and what is right of it
    int out_place = roots.low <= t_out ? curved : place_out;
    int in_place = roots.high >= t_in ? curved : place_in;
    float first_out = min(roots.low, t_out), second_in = max(roots.high, t_in);
    bool first = t_in < first_out, second = second_in < t_out;
    if (first && second)
        return Spans(2, t_in, first_out, second_in, t_out, place_in, out_place, in_place, place_out);
    if (second) return Spans(1, second_in, t_out, FAR, -FAR, in_place, place_out, NO_PLACE, NO_PLACE);
    one.out1 = first_out;
    one.b1 = out_place;
    one.count = first ? 1 : 0;
    return one;
}

// (surface, face number, side) of a place; side +1 where the surface's gradient points out of the cell
ivec3 place_face(int place) {
    if (place == CUT_PLACE) return ivec3(CUT, -1, 1);
    if (place == NO_PLACE) return ivec3(NO_SURFACE, 0, 1);
    if (place < 0) {
        ivec4 cell = integer4(CELLS, -2 - place);
        return ivec3(cell.x, cell.y >> 1, (cell.y & 1) == 1 ? 1 : -1);
    }
    ivec4 slot = integer4(SLOTS, place);
    return ivec3(slot.x, slot.z, slot.y);
}
