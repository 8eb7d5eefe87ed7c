// A cell on a ray. At most two spans, each end with the place of its face: a row of the cells' planes,
// -2 - cell for its curved face, NO_PLACE at infinity, CUT_PLACE on the section plane.

const int NO_PLACE = -1;
const int CUT_PLACE = 0x7fffffff;

struct CellSpans {
    int number;
    float in1, out1;
    int place_in1, place_out1;
    float in2, out2;
    int place_in2, place_out2;
};

// One span, none where t_in >= t_out
struct Slab {
    float t_in, t_out;
    int place_in, place_out;
};

const Slab EVERYWHERE = Slab(-FAR, FAR, NO_PLACE, NO_PLACE);
const Slab NOWHERE = Slab(FAR, -FAR, NO_PLACE, NO_PLACE);

// Where height + rate t is zero
float zero_of(float height, float rate) {
    return rate == 0.0 ? FAR : clamp(-height / rate, -FAR, FAR);
}

// (height, rate) of a plane on a ray: its value at t is height + rate t, 0 at the start of one on it
vec2 plane_values(int surface, Ray ray) {
    int at = integer4(SURFACE, surface).y;
    return vec2(surface == ray.start ? 0.0 : plane_height(at, ray.o), dot(real4(at).xyz, ray.d));
}

// (t, rate): where the ray crosses a plane
vec2 plane_crossing(int surface, Ray ray) {
    vec2 plane = plane_values(surface, ray);
    return vec2(zero_of(plane.x, plane.y), plane.y);
}

// A slab cut by one more plane; `inner`: what is kept is where height + rate t is negative. A ray within the plane
// counts as if the plane stood an infinitesimal further along its normal
Slab clip_slab(Slab slab, float height, float rate, bool inner, int place) {
    float t = zero_of(height, rate);
    if (rate == 0.0) {
        if ((height <= 0.0) != inner) return NOWHERE;
    } else if ((rate < 0.0) == inner) {
        if (t > slab.t_in) { slab.t_in = t; slab.place_in = place; }
    } else if (t < slab.t_out) { slab.t_out = t; slab.place_out = place; }
    return slab;
}

// What the planes of a cell leave of a ray
Slab slab_of(int cell, Ray ray) {
    ivec4 row = integer4(CELLS, cell);
    Slab slab = EVERYWHERE;
    for (int slot = row.z; slot < row.w; slot++) {
        ivec4 face = integer4(SLOTS, slot);
        vec2 plane = plane_values(face.x, ray);
        slab = clip_slab(slab, plane.x, plane.y, face.y > 0, slot);
    }
    return slab;
}

// The spans that a quadric leaves of a slab: `outside` of its roots, or between them; `curved` is its place.
// Where the ray does not cross it, all of the slab is left if `outside`, else nothing
CellSpans compose_spans(Slab slab, float low, float high, bool crosses, bool outside, int curved) {
    CellSpans none = CellSpans(0, FAR, -FAR, NO_PLACE, NO_PLACE, FAR, -FAR, NO_PLACE, NO_PLACE);
    if (!(slab.t_in < slab.t_out)) return none;
    CellSpans one = CellSpans(1, slab.t_in, slab.t_out, slab.place_in, slab.place_out, FAR, -FAR, NO_PLACE, NO_PLACE);
    if (!crosses) {
        one.number = outside ? 1 : 0;
        return one;
    }
    if (!outside) {
        one.place_in1 = low >= slab.t_in ? curved : slab.place_in;
        one.place_out1 = high <= slab.t_out ? curved : slab.place_out;
        one.in1 = max(low, slab.t_in);
        one.out1 = min(high, slab.t_out);
        one.number = one.in1 < one.out1 ? 1 : 0;
        return one;
    }
    // Outside of ]low, high[: what is left of it and what is right of it
    float out1 = min(low, slab.t_out), in2 = max(high, slab.t_in);
    int place_out1 = low <= slab.t_out ? curved : slab.place_out, place_in2 = high >= slab.t_in ? curved : slab.place_in;
    bool some = slab.t_in < out1, more = in2 < slab.t_out;
    if (some && more)
        return CellSpans(2, slab.t_in, out1, slab.place_in, place_out1, in2, slab.t_out, place_in2, slab.place_out);
    if (more) return CellSpans(1, in2, slab.t_out, place_in2, slab.place_out, FAR, -FAR, NO_PLACE, NO_PLACE);
    one.out1 = out1;
    one.place_out1 = place_out1;
    one.number = some ? 1 : 0;
    return one;
}

// The spans of a ray inside a cell, in order; contacts of zero length are none
CellSpans cell_spans(int cell, Ray ray, float inverse) {
    ivec4 row = integer4(CELLS, cell);
    Slab slab = slab_of(cell, ray);
    Roots roots = Roots(FAR, FAR, true, false);
    if (row.x >= 0) {
        roots = curved_roots(row.x, ray, inverse);
        roots.outside = roots.outside != (number_and_side(row.y).y < 0);
    }
    return compose_spans(slab, roots.low, roots.high, roots.crosses, roots.outside, -2 - cell);
}

// The span of a ray inside a ball
CellSpans ball_spans(int surface, Ray ray, float inverse) {
    Roots roots = curved_roots(surface, ray, inverse);
    return compose_spans(EVERYWHERE, roots.low, roots.high, roots.crosses, false, NO_PLACE);
}

// (surface, face number, side) of a place; side +1 where the surface's gradient points out of the cell
ivec3 place_face(int place) {
    if (place == CUT_PLACE) return ivec3(CUT, -1, 1);
    if (place == NO_PLACE) return ivec3(NO_SURFACE, 0, 1);
    if (place < 0) {
        ivec4 cell = integer4(CELLS, -2 - place);
        return ivec3(cell.x, number_and_side(cell.y));
    }
    ivec4 slot = integer4(SLOTS, place);
    return ivec3(slot.x, slot.z, slot.y);
}
