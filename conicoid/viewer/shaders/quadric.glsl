// A quadric on a ray, in single precision, and the height of a point over a plane.
// With y = W (x - anchor) the surface is  sum s_i y_i² + 2 b_i y_i - k = 0; on the ray, about the foot of the
// perpendicular from the anchor, a t² + 2 b t + c; the discriminant is taken in its moment form.

struct Roots {
    float low, high;
    bool outside, crosses;
};

// Each root by the formula that does not cancel: q = -(b + sign(b) sqrt(b² - a c)); t = q / a and c / q
Roots roots_of(float a, float b, float c, float discriminant, float shift) {
    bool crosses = discriminant > 1e-36;
    float root = sqrt(crosses ? discriminant : 1.0);
    float q = -(b + (b < 0.0 ? -root : root));
    float first = abs(a) < 1e-30 * abs(q) ? (q < 0.0 ? -FAR : FAR) : q / a + shift;
    float second = c / q + shift;
    bool outside = a < 0.0 || (a == 0.0 && !crosses && c < 0.0);
    return Roots(max(min(first, second), -FAR), min(max(first, second), FAR), outside, crosses);
}

Roots sphere_roots(vec4 sphere, Ray ray, float inverse, bool starts) {
    vec3 p = ray.o - sphere.xyz;
    float r = sphere.w, a = dot(ray.d, ray.d);
    float foot = starts ? 0.0 : -dot(p, ray.d) * inverse;
    p += foot * ray.d;
    float b = dot(p, ray.d);
    vec3 m = cross(p, ray.d);
    float c = starts ? 0.0 : dot(p, p) - r * r;
    float discriminant = starts ? b * b : a * (r * r) - dot(m, m);
    return roots_of(a, b, c, discriminant, foot);
}

struct Quadric {
    vec3 anchor, w0, w1, w2, s, b;
    float k;
};

Quadric load_quadric(int at) {
    vec4 f0 = real4(at), f1 = real4(at + 1), f2 = real4(at + 2), f3 = real4(at + 3), f4 = real4(at + 4);
    return Quadric(f0.xyz, vec3(f0.w, f1.xy), vec3(f1.zw, f2.x), f2.yzw, f3.xyz, vec3(f3.w, f4.xy), f4.z);
}

vec3 own(Quadric q, vec3 v) {
    return vec3(dot(q.w0, v), dot(q.w1, v), dot(q.w2, v));
}

Roots quadric_roots(Quadric q, Ray ray, float inverse, bool starts) {
    vec3 p = ray.o - q.anchor;
    float foot = starts ? 0.0 : -dot(p, ray.d) * inverse;
    p += foot * ray.d;
    vec3 e = own(q, ray.d), y = own(q, p);
    vec3 f = q.s * e;
    float g = dot(q.b, e);
    float a = dot(f, e) + 0.0;
    float b = dot(f, y) + g;
    float c = starts ? 0.0 : dot(q.s * y + 2.0 * q.b, y) - q.k;
    vec3 m = cross(y, e);
    vec3 t = q.s.yxx * q.s.zzy * m * m;
    float h = dot(m, cross(f, q.b));
    float discriminant = starts ? b * b : (a * q.k - (t.x + t.y + t.z)) + (g * g + 2.0 * h);
    return roots_of(a, b, c, discriminant, foot);
}

// Half the gradient at a point
vec3 quadric_gradient(Quadric q, vec3 x) {
    vec3 g = q.s * own(q, x - q.anchor) + q.b;
    return g.x * q.w0 + g.y * q.w1 + g.z * q.w2;
}

Roots curved_roots(int surface, Ray ray, float inverse) {
    ivec2 row = integer4(SURFACE, surface).xy;
    bool starts = surface == ray.start;
    if (row.x == SPHERE) return sphere_roots(real4(row.y), ray, inverse, starts);
    return quadric_roots(load_quadric(row.y), ray, inverse, starts);
}

// n·x - offset of the plane whose records begin at `at`
float plane_height(int at, vec3 x) {
    vec4 plane = real4(at);
    return dot(plane.xyz, x - real4(at + 1).xyz) + plane.w;
}

bool is_curved(int surface) {
    return integer4(SURFACE, surface).x != PLANE;
}
