// The queries that integrators make: the nearest crossing, any opaque one, the media on both sides of a point, and
// the sum of the chords. One function, so that a driver compiles the walk once.

// NOTICED: the nearest, at equal t an opaque one first; BLOCKED: any crossing of an opaque body
const int NEAREST = 0, BLOCKED = 1, MEDIA_AT = 2, THROUGH = 3, NOTICED = 4;

struct Hit {
    float t;
    int body, surface, face, side;
    bool enters;
    ivec2 media;   // MEDIA_AT: the first transparent solid before and after ray.t_min, or -1
    float chord;   // THROUGH
};

int flags_of(int body) {
    return integer4(BODIES, body).z;
}

// The rule of ties: the nearer of two crossings; at equal t that of the body listed first, by its rank
bool comes_first(float t, int rank, float other_t, int other_rank) {
    return t < other_t || (t == other_t && rank < other_rank);
}

// The place of a body among those with equal t
int rank_of(int body, int flags, int mode) {
    return mode == NOTICED && (flags & OPAQUE) == 0 ? body | (1 << 30) : body;
}

Hit traverse(Ray ray, int mode, int after_body) {
    Hit best = Hit(FAR, -1, NO_SURFACE, -1, 1, false, ivec2(-1), 0.0);
    int best_rank = 0x7fffffff, place = NO_PLACE, sense = 1;
    ivec4 best_entry = ivec4(0);
    float inverse = 1.0 / dot(ray.d, ray.d);
    vec3 d = reciprocal(ray.d);
    put_section(ray);
    stack_top = 0;
    push_roots(u_tree);
    float t_max = mode == MEDIA_AT ? ray.t_min : ray.t_max;
    int asked = mode == MEDIA_AT ? MEDIA : (mode == THROUGH ? CHORDS : FIRST);
    while (stack_top > 0) {
        stack_top--;
        if (stack_t[stack_top] > min(t_max, best.t)) continue;
        int code = stack_code[stack_top];
        if (code >= 0) { push_node(code, ray, d, ray.t_min, min(t_max, best.t)); continue; }
        ivec2 range = leaf_range(code);
        for (int k = range.x; k < range.y; k++) {
            ivec4 entry = integer4(ENTRIES, integer4(ORDER, k).x);
            int body = entry.z, flags = flags_of(body);
            if ((flags & HIDDEN) != 0 || (mode == BLOCKED && (flags & OPAQUE) == 0)) continue;
            if (mode == MEDIA_AT && (flags & MEDIUM) == 0) continue;
            Ray part = ray;
            part.t_max = mode == THROUGH ? ray.t_max : min(ray.t_max, best.t + abs(best.t) * 1e-6 + 1e-30);
            tie_counts = body > after_body;
            Crossing crossing = entry_crossing(entry, part, inverse, asked);
            best.chord += crossing.chord;
            if (crossing.before && (best.media.x < 0 || body < best.media.x)) best.media.x = body;
            if (crossing.after && (best.media.y < 0 || body < best.media.y)) best.media.y = body;
            if (mode != MEDIA_AT && crossing.found && comes_first(crossing.t, rank_of(body, flags, mode), best.t, best_rank)) {
                best.t = crossing.t;
                best.body = body;
                best.enters = crossing.enters;
                best_rank = rank_of(body, flags, mode);
                best_entry = entry;
                place = crossing.place;
                sense = crossing.sense;
                if (mode == BLOCKED) return best;
            }
        }
    }
    if (best.body >= 0) {
        ivec3 face = crossed_face(best_entry, place, sense);
        best.surface = face.x;
        best.face = face.y;
        best.side = face.z;
    }
    return best;
}

// Unit normal of a surface at a point, times `side`; a cone's apex has its axis
vec3 normal_at(int surface, int side, vec3 x) {
    if (surface == CUT) return u_section.xyz;
    ivec2 row = integer4(SURFACE, surface).xy;
    vec3 n;
    if (row.x == PLANE) n = real4(row.y).xyz;
    else if (row.x == SPHERE) n = x - real4(row.y).xyz;
    else {
        Quadric quadric = load_quadric(row.y);
        n = quadric_gradient(quadric, x);
        if (dot(n, n) == 0.0) n = quadric.w2;
    }
    return float(side) * normalized(n);
}

// A point of a plane put back on it: single precision leaves it, and a pattern in space would show that
vec3 on_surface(int surface, vec3 x) {
    if (surface < 0) return x;
    ivec2 row = integer4(SURFACE, surface).xy;
    if (row.x != PLANE) return x;
    vec3 n = real4(row.y).xyz;
    return x - n * (plane_height(row.y, x) / dot(n, n));
}

// The angle of (x, y) as a fraction of a full turn, in [0, 1)
float turns(float x, float y) {
    if (y == 0.0) return x < 0.0 ? 0.5 : 0.0;   // drivers differ about atan(-0.0, x)
    float angle = atan(y, x) / 6.283185307179586;
    angle = angle < 0.0 ? angle + 1.0 : angle;
    return angle >= 1.0 ? 0.0 : angle;
}

vec2 uv_at(int body, int face, int surface, vec3 x) {
    int first = integer4(BODIES, body).x;
    if (first < 0) {
        // One of many balls: longitude and height
        ivec2 row = integer4(SURFACE, surface).xy;
        vec3 p = x - real4(row.y).xyz;
        int at = u_frames + 3 * (-1 - first);
        p = vec3(dot(real4(at).xyz, p), dot(real4(at + 1).xyz, p), dot(real4(at + 2).xyz, p));
        return vec2(turns(p.x, p.y), 0.5 * p.z / length(p) + 0.5);
    }
    int at = integer4(FACES, first + face).y;
    vec4 p = vec4(x, 1.0);
    float a = dot(real4(at), p), b = dot(real4(at + 1), p);
    return real4(at + 3).x == 0.0 ? vec2(a, b) : vec2(turns(a, b), dot(real4(at + 2), p));
}
