// The engine's tables, as records of two textures: four integers, or four floats.
// u_place holds where each table begins. All places are relative to an origin that the page keeps near the camera.

uniform highp sampler2D u_floats;
uniform highp isampler2D u_ints;
uniform int u_place[14];

// tables of integers
const int SURFACE = 0;   // kind, first record of its floats
const int CELLS = 1;     // quadric or -1, 2 face + (side > 0), first plane, last plane
const int SLOTS = 2;     // planes of cells: surface, side, face
const int LEAVES = 3;    // cell, gate, negated, sense
const int GATE = 4;      // parent, need, negated, start
const int PROGRAMS = 5;  // first leaf, first gate, last gate
const int SHEETS = 6;    // surface, program, side, one-sided
const int POLYGONS = 7;  // surface and side, program, first vertex, last vertex
const int ENTRIES = 8;   // kind, index, body
const int BODIES = 9;    // first face, material, flags, tint
const int FACES = 10;    // material of its own or -1, first record of its uv map
const int CHILDREN = 11; // two records a node
const int ORDER = 12;    // what the trees hold, in leaf order
const int ROOTS = 13;    // where the walk of a tree begins and ends, then the roots themselves
uniform int u_boxes;     // tables of floats: 12 records a node
uniform int u_vertices;
uniform int u_materials;
uniform int u_lights;
uniform int u_frames;
uniform int u_tree;      // the scene's own tree
uniform int u_root_list;

const int PLANE = 0, SPHERE = 1, QUADRIC = 2;
const int BALL = 0, CELL = 1, REGION = 2, SHEET = 3, POLYGON = 4;
const int OPAQUE = 1, MEDIUM = 2, HIDDEN = 4, TINTED = 8;

const float FAR = 1e30;  // in place of infinity, which WebGL does not guarantee
const int NO_SURFACE = -1;
const int CUT = -2;      // the section plane as a surface

struct Ray {
    vec3 o, d;
    float t_min, t_max;
    int start;           // the surface it starts on
};

vec4 real4(int i) {
    return texelFetch(u_floats, ivec2(i & (TEXTURE_WIDTH - 1), i >> TEXTURE_SHIFT), 0);
}

ivec4 record(int i) {
    return texelFetch(u_ints, ivec2(i & (TEXTURE_WIDTH - 1), i >> TEXTURE_SHIFT), 0);
}

ivec4 integer4(int table, int i) {
    return record(u_place[table] + i);
}

// (number, side) that stand in one integer
ivec2 number_and_side(int packed) {
    return ivec2(packed >> 1, (packed & 1) == 1 ? 1 : -1);
}
