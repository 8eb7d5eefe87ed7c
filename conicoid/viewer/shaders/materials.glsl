// Materials, patterns, media and the background.

struct Material {
    vec3 color, second, scale, specular, reflectivity, transparency, absorption, offset;
    float ambient, diffuse, shininess, index;
    int pattern;
    bool half_vector, fresnel;
};

const int OUTSIDE = -1;

Material load_material(int row) {
    int at = u_materials + 8 * row;
    vec4 a = real4(at), b = real4(at + 1), c = real4(at + 2), d = real4(at + 3);
    vec4 e = real4(at + 4), f = real4(at + 5), g = real4(at + 6), h = real4(at + 7);
    return Material(a.rgb, b.rgb, c.xyz, d.rgb, e.rgb, f.rgb, g.rgb, h.xyz, b.w, c.w, d.w, g.w,
                    int(a.w), e.w > 0.5, f.w > 0.5);
}

// The row of a face's material: its own, or its body's
int material_row(int body, int face) {
    ivec4 row = integer4(BODIES, body);
    if (row.x >= 0 && face >= 0) {
        int own_row = integer4(FACES, row.x + face).x;
        if (own_row >= 0) return own_row;
    }
    return row.y;
}

bool is_even(vec3 cell) {
    vec3 f = floor(cell);
    return mod(f.x + f.y + f.z, 2.0) < 0.5;
}

// The diffuse colour at a point; n is the body's outward normal. A pattern in space is read a little under it
vec3 surface_color(Material m, int body, int face, int surface, vec3 x, vec3 n) {
    ivec4 row = integer4(BODIES, body);
    if ((row.z & TINTED) != 0) return pow(vec3(row.w >> 16 & 255, row.w >> 8 & 255, row.w & 255) / 255.0, vec3(2.2));
    if (m.pattern == 0) return m.color;
    if (m.pattern == 1 && face >= 0) {
        vec2 uv = uv_at(body, face, surface, x);
        return is_even(vec3(uv / m.scale.xy, 0.0)) ? m.color : m.second;
    }
    vec3 cell = x / m.scale + m.offset - 1.220703125e-4 * n;
    return is_even(cell) ? m.color : m.second;
}

int medium_of(int body) {
    return body >= 0 ? integer4(BODIES, body).y : OUTSIDE;
}

float index_of(int medium) {
    return medium >= 0 ? load_material(medium).index : 1.0;
}

vec3 absorption_of(int medium) {
    return medium >= 0 ? load_material(medium).absorption : vec3(0.0);
}

// Does light pass the wall of a transparent body as if nothing were there?
bool unseen(int body, int before, int after) {
    if (before == after) return true;
    Material wall = load_material(medium_of(body));
    return index_of(before) == index_of(after) && absorption_of(before) == absorption_of(after)
        && wall.transparency == vec3(1.0) && wall.specular == vec3(0.0);
}

// Light after a length of way through a medium (Beer)
vec3 absorbed(int medium, float length_inside, vec3 light) {
    if (medium < 0 || length_inside <= 0.0) return light;
    vec3 a = absorption_of(medium);
    return light * vec3(a.r > 0.0 ? exp(-a.r * length_inside) : 1.0, a.g > 0.0 ? exp(-a.g * length_inside) : 1.0,
                        a.b > 0.0 ? exp(-a.b * length_inside) : 1.0);
}

uniform vec3 u_sky[3];  // straight up, at the horizon, straight down

vec3 background_color(float dz) {
    return mix(u_sky[1], dz > 0.0 ? u_sky[0] : u_sky[2], sqrt(min(1.0, abs(dz))));
}

// Fresnel's reflectance between two dielectrics; eta = index here / index beyond; cos2 < 0: total
float dielectric(float cos1, float cos2, float eta) {
    if (cos2 < 0.0 || (cos1 <= 0.0 && cos2 <= 0.0)) return 1.0;
    float s = (eta * cos1 - cos2) / (eta * cos1 + cos2), p = (cos1 - eta * cos2) / (cos1 + eta * cos2);
    return 0.5 * (s * s + p * p);
}

vec3 opaque_reflectance(Material m, float cosine) {
    float k = 1.0 - cosine;
    return m.fresnel ? m.reflectivity + (1.0 - m.reflectivity) * (k * k * k * k * k) : m.reflectivity;
}

// (direction behind the surface, cos θ₂), cos θ₂ = -1 where reflection is total
vec4 refracted(vec3 d, vec3 n, float eta) {
    float along = dot(d, n);
    float square = (1.0 - eta) * (1.0 + eta) + (eta * along) * (eta * along);
    if (square < 0.0) return vec4(0.0, 0.0, 0.0, -1.0);
    float cosine = sqrt(square);
    return vec4(eta * (d - along * n) - cosine * n, cosine);
}

// Fresnel's reflectance of a wall for light from the rarer side
float wall_reflectance(float cosine, float index1, float index2) {
    float eta = min(index1, index2) / max(index1, index2);
    float beyond = 1.0 - eta * eta * (1.0 - cosine * cosine);
    return dielectric(min(1.0, cosine), sqrt(max(0.0, beyond)), eta);
}
