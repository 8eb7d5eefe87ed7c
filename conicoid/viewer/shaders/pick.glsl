// The crossings of one ray, one to a column: bits of (t, body, face, surface), (normal, entering), (uv, chord, 0).

uniform vec2 u_pixel;
out uvec4 words;

void main() {
    int column = int(gl_FragCoord.x), row = int(gl_FragCoord.y), after_body = 0x7fffffff;
    Ray ray = camera_ray(u_pixel);
    Hit hit;
    for (int k = 0; k <= column; k++) {
        hit = traverse(ray, NEAREST, after_body);
        if (hit.body < 0) break;
        ray.t_min = hit.t;
        after_body = hit.body;
    }
    words = uvec4(floatBitsToUint(hit.t), uint(hit.body), uint(hit.face), uint(hit.surface));
    if (row == 0 || hit.body < 0) return;
    vec3 x = ray.o + hit.t * ray.d;
    if (row == 1) words = uvec4(floatBitsToUint(normal_at(hit.surface, hit.side, x)), hit.enters ? 1u : 0u);
    else words = uvec4(floatBitsToUint(hit.face >= 0 ? uv_at(hit.body, hit.face, hit.surface, x) : vec2(0.0)), 0u, 0u);
}
