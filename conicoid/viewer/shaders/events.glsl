// The crossings of a ray with one body, in order.
// The span ends of a region's leaves are events, taken in groups of equal t. Storage is bounded: only the
// next EVENTS of them are kept, sorted; when they are used up the leaves are tested again for those after.

float event_t[EVENTS];
int event_key[EVENTS];    // 4 leaf + its end: even ones enter
int event_place[EVENTS];
int event_count;
bool events_left;         // some had no room
float taken_t;            // all up to this (t, key) have been taken
int taken_key;

const int FIRST = 0, MEDIA = 1, CHORDS = 2, CLOSED = 3;  // what is computed for an entry

// The result for an entry
struct Crossing {
    bool found;
    float t;
    int place, sense;
    bool enters;
    bool before, after;   // MEDIA: inside just before and just after ray.t_min; CLOSED: `after`
    float chord;          // CHORDS: length inside of (t_min, t_max)
};

uniform vec4 u_section;   // normal and offset of the half-space that is kept
uniform bool u_cuts;
float cut_in, cut_out;    // where the ray is in it
bool tie_counts;          // does a crossing at t_min itself count?

void put_section(Ray ray) {
    Slab kept = EVERYWHERE;
    if (u_cuts) {
        float height = ray.start == CUT ? 0.0 : dot(u_section.xyz, ray.o) - u_section.w;
        kept = clip_slab(kept, height, dot(u_section.xyz, ray.d), true, CUT_PLACE);
    }
    cut_in = kept.t_in;
    cut_out = kept.t_out;
}

bool is_after(int i, float t, int key) {
    return event_t[i] > t || (event_t[i] == t && event_key[i] > key);
}

void put_event(float t, int key, int place) {
    if (t < taken_t || (t == taken_t && key <= taken_key)) return;
    if (event_count == EVENTS) {
        events_left = true;
        if (!is_after(EVENTS - 1, t, key)) return;
        event_count--;
    }
    int j = event_count++;
    for (; j > 0 && is_after(j - 1, t, key); j--) {
        event_t[j] = event_t[j - 1];
        event_key[j] = event_key[j - 1];
        event_place[j] = event_place[j - 1];
    }
    event_t[j] = t;
    event_key[j] = key;
    event_place[j] = place;
}

// The next events of a program after those taken
void gather(int program, Ray ray, float inverse, float last) {
    event_count = 0;
    events_left = false;
    int base = stack_top;
    vec3 d = reciprocal(ray.d);
    push_roots(program);
    while (stack_top > base) {
        int code = stack_code[--stack_top];
        if (code >= 0) { push_node(code, ray, d, -FAR, last); continue; }
        ivec2 range = leaf_range(code);
        for (int k = range.x; k < range.y; k++) {
            int leaf = integer4(ORDER, k).x;
            CellSpans s = cell_spans(integer4(LEAVES, leaf).x, ray, inverse);
            if (s.number > 0) { put_event(s.in1, 4 * leaf, s.place_in1); put_event(s.out1, 4 * leaf + 1, s.place_out1); }
            if (s.number > 1) { put_event(s.in2, 4 * leaf + 2, s.place_in2); put_event(s.out2, 4 * leaf + 3, s.place_out2); }
        }
    }
}

// The events of a group from number `first` on whose leaves decide before it: one bit each, none for a lone event
uint deciders(int first) {
    uint bits = 0u;
    int k = first;
    for (; k < event_count && event_t[k] == event_t[first]; k++)
        if (leaf_decides(integer4(LEAVES, event_key[k] >> 2), (event_key[k] & 1) == 1)) bits |= 1u << uint(k - first);
    return k - first > 1 ? bits : 0u;
}

// (place, sense) of the first event of a group whose leaf turns the body: of the `deciders`, one that decides after it
// as well. Else `any`, a place and whether its leaf is entered (1, -1).
ivec2 deciding_face(int first, uint bits, bool entered, ivec2 any) {
    for (int k = first; bits != 0u; k++) {
        ivec4 leaf = integer4(LEAVES, event_key[k] >> 2);
        bool on = (event_key[k] & 1) == 0, fits = on == (entered == (leaf.w > 0));
        if ((bits & 1u) == 1u && fits && leaf_decides(leaf, on)) return ivec2(event_place[k], leaf.w);
        bits >>= 1;
    }
    return ivec2(any.x, entered ? any.y : -any.y);
}

Crossing no_crossing() {
    return Crossing(false, FAR, NO_PLACE, 1, false, false, false, 0.0);
}

Crossing at_crossing(float t, int place, int sense, bool enters) {
    return Crossing(true, t, place, sense, enters, false, false, 0.0);
}

// Is a crossing within (t_min, t_max), and not the one that the ray starts on? `starts`: it is with the start's surface
bool counts_in(float t, bool starts, float t_min, float t_max) {
    return (t > t_min || (t == t_min && tie_counts)) && t < t_max && !(t == 0.0 && starts);
}

// The surface of a place where it matters: at t = 0, where it may be the one that the ray starts on
int surface_of(int place, float t, int ball) {
    if (t != 0.0) return NO_SURFACE;
    return ball >= 0 && place != CUT_PLACE ? ball : place_face(place).x;
}

// Spans of a ball or a cell, cut by the section plane
Crossing spans_crossing(CellSpans s, Ray ray, int mode, int ball) {
    Crossing result = no_crossing();
    for (int k = 0; k < s.number; k++) {
        float a = k == 0 ? s.in1 : s.in2, b = k == 0 ? s.out1 : s.out2;
        int place_a = k == 0 ? s.place_in1 : s.place_in2, place_b = k == 0 ? s.place_out1 : s.place_out2;
        if (cut_in > a) { a = cut_in; place_a = CUT_PLACE; }
        if (cut_out < b) { b = cut_out; place_b = CUT_PLACE; }
        if (!(a < b)) continue;
        if (mode == MEDIA) {
            result.before = result.before || (a < ray.t_min && ray.t_min <= b);
            result.after = result.after || (a <= ray.t_min && ray.t_min < b);
        } else if (mode == CHORDS) {
            result.chord += max(0.0, min(b, ray.t_max) - max(a, ray.t_min));
        } else if (a < result.t && counts_in(a, surface_of(place_a, a, ball) == ray.start, ray.t_min, ray.t_max)) {
            result = at_crossing(a, place_a, 1, true);
        } else if (b < result.t && counts_in(b, surface_of(place_b, b, ball) == ray.start, ray.t_min, ray.t_max)) {
            result = at_crossing(b, place_b, 1, false);
        }
    }
    return result;
}

// Sweep the events of a region: a crossing is where its truth differs before and after a group of equal t
Crossing region_crossing(int program, Ray ray, float inverse, int mode) {
    ivec4 row = integer4(PROGRAMS, program);
    start_gates(row.y, row.z);
    Crossing result = no_crossing();
    float low = max(ray.t_min, cut_in), high = min(ray.t_max, cut_out), chord_from = low;
    float stop = mode == MEDIA || mode == CLOSED ? ray.t_min : high;
    if (mode == CLOSED) low = FAR;
    bool inside = root_value(), started = false;
    float group = -2.0 * FAR;
    ivec2 any = ivec2(NO_PLACE, 1);
    int first = 0;   // of the group's events, or -1 before they are taken
    uint bits = 0u;  // its `deciders`, but for a group of more than EVENTS
    taken_t = -2.0 * FAR;
    taken_key = -1;
    event_count = 0;
    events_left = true;
    int i = 0;
    while (true) {
        if (i == event_count && events_left) { gather(program, ray, inverse, stop); i = 0; bits = 0u; }
        bool more = i < event_count && event_t[i] <= stop;
        float t = more ? event_t[i] : 2.0 * FAR;
        if (t > group) {
            // The group before is complete
            bool now = root_value();
            if (mode == MEDIA) {
                if (group < ray.t_min) result.before = now;
                result.after = now;
                inside = now;
            } else if (group > low || (group == low && tie_counts && !u_cuts)) {
                if (now != inside && group < high) {
                    ivec2 face = deciding_face(first, bits, now, any);
                    if (mode == CHORDS) {
                        if (now) chord_from = group;
                        else result.chord += group - chord_from;
                    } else if (!(group == 0.0 && place_face(face.x).x == ray.start)) {
                        return at_crossing(group, face.x, face.y, now);
                    }
                }
                if (group < high) inside = now;
            } else {
                inside = now;
            }
            if (!started && t > low) {
                started = true;
                bool cut = u_cuts && low == cut_in && low < high && counts_in(low, ray.start == CUT, ray.t_min, ray.t_max);
                if (inside && mode <= FIRST && cut)
                    return at_crossing(low, CUT_PLACE, 1, true);
            }
            if (!more) break;
            group = t;
            first = -1;
            // Perhaps its last ones had no room: gather from its first one on
            if (i > 0 && events_left && event_t[event_count - 1] == t) { i = event_count; continue; }
        }
        if (first < 0) {
            first = i;
            any = ivec2(event_place[i], (event_key[i] & 1) == 0 ? 1 : -1);
            bits = mode == FIRST ? deciders(i) : 0u;
        }
        ivec4 leaf = integer4(LEAVES, event_key[i] >> 2);
        bool on = (event_key[i] & 1) == 0;
        if (mode != CLOSED || on || t < ray.t_min) turn_leaf(leaf, on);
        taken_t = t;
        taken_key = event_key[i];
        i++;
    }
    if (mode == CLOSED) {
        result.after = root_value();
    } else if (mode == MEDIA) {
        result.before = result.before && cut_in < ray.t_min && ray.t_min <= cut_out;
        result.after = result.after && cut_in <= ray.t_min && ray.t_min < cut_out;
    } else if (inside && low < high) {
        if (mode == CHORDS) result.chord += high < FAR ? high - chord_from : 0.0;
        else if (high == cut_out && counts_in(high, ray.start == CUT, ray.t_min, ray.t_max))
            return at_crossing(high, CUT_PLACE, 1, false);
    }
    return result;
}

// A clipped surface, or a polygon, which has vertices
struct Sheet {
    int surface, program, side, first_vertex, last_vertex;
    bool one_sided;
};

Sheet sheet_of(ivec4 entry) {
    if (entry.x == SHEET) {
        ivec4 row = integer4(SHEETS, entry.y);
        return Sheet(row.x, row.y, row.z, 0, 0, row.w == 1);
    }
    if (entry.x != POLYGON) return Sheet(NO_SURFACE, -1, 1, 0, 0, false);
    ivec4 row = integer4(POLYGONS, entry.y);
    ivec2 surface = number_and_side(row.x);
    return Sheet(surface.x, row.y, surface.y, row.z, row.w, false);
}

// The first crossing of an entry's body, or what else the mode says
Crossing entry_crossing(ivec4 entry, Ray ray, float inverse, int mode) {
    int kind = entry.x, index = entry.y;
    if (kind == BALL || kind == CELL) {
        CellSpans s;
        if (kind == BALL) s = ball_spans(index, ray, inverse);
        else s = cell_spans(index, ray, inverse);
        return spans_crossing(s, ray, mode, kind == BALL ? index : NO_SURFACE);
    }
    int program = index, rounds = 1;
    float low = FAR, high = FAR;
    bool falls = false;
    Sheet sheet = sheet_of(entry);
    if (kind != REGION) {
        if (mode == MEDIA || mode == CHORDS) return no_crossing();
        program = sheet.program;
        if (kind == POLYGON && !inside_loop(sheet.first_vertex, sheet.last_vertex, ray)) return no_crossing();
        if (is_curved(sheet.surface)) {
            Roots r = curved_roots(sheet.surface, ray, inverse);
            if (!r.crosses) return no_crossing();
            low = r.low; high = r.high; falls = !r.outside; rounds = 2;
        } else {
            vec2 crossing = plane_crossing(sheet.surface, ray);
            if (crossing.y == 0.0) return no_crossing();
            low = crossing.x; falls = crossing.y < 0.0;
        }
    }
    for (int k = 0; k < rounds; k++) {
        float t = k == 0 ? low : high;
        bool against = (falls != (k == 1)) == (sheet.side > 0);
        Ray asked = ray;
        if (kind != REGION) {
            if (!counts_in(t, sheet.surface == ray.start, ray.t_min, ray.t_max) || (sheet.one_sided && !against)) continue;
            if (program < 0) return at_crossing(t, NO_PLACE, 1, against);
            asked.t_min = t;
        }
        Crossing crossing = no_crossing();
#if ANY_PROGRAM
        crossing = region_crossing(program, asked, inverse, kind == REGION ? mode : CLOSED);
#endif
        if (kind == REGION) return crossing;
        if (crossing.after) return at_crossing(t, NO_PLACE, 1, against);
    }
    return no_crossing();
}

// (surface, face number, side) of a crossing of an entry
ivec3 crossed_face(ivec4 entry, int place, int sense) {
    if (place == CUT_PLACE) return ivec3(CUT, -1, 1);
    if (entry.x == BALL) return ivec3(entry.y, 0, 1);
    if (entry.x == SHEET || entry.x == POLYGON) {
        Sheet sheet = sheet_of(entry);
        return ivec3(sheet.surface, 0, sheet.side);
    }
    ivec3 face = place_face(place);
    return ivec3(face.xy, face.z * sense);
}
