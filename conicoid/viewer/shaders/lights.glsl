// Lights, highlights, and the light that arrives at a point.

uniform int u_light_count;
uniform vec3 u_ambient;
uniform float u_softness;   // radius given to lights, as a share of their distance
uniform int u_sample;       // the first sample takes pixel centres and points of light

struct Light {
    vec3 position, axis, intensity;
    bool parallel, fades;
    float outer, inner, radius;
};

Light load_light(int k) {
    int at = u_lights + 4 * k;
    vec4 a = real4(at), b = real4(at + 1), c = real4(at + 2), d = real4(at + 3);
    return Light(a.xyz, b.xyz, c.rgb, a.w > 0.5, b.w > 0.5, c.w, d.x, d.y);
}

uint noise_state;

float noise() {
    noise_state = noise_state * 747796405u + 2891336453u;
    uint word = ((noise_state >> ((noise_state >> 28u) + 4u)) ^ noise_state) * 277803737u;
    return float((word >> 22u) ^ word) / 4294967296.0;
}

vec3 noise_in_ball() {
    float z = 2.0 * noise() - 1.0, angle = 6.283185307 * noise(), r = pow(noise(), 1.0 / 3.0);
    return r * vec3(sqrt(max(0.0, 1.0 - z * z)) * vec2(cos(angle), sin(angle)), z);
}

// (direction, end): the ray from x to the light meets it at parameter `end`
vec4 towards(Light light, vec3 x) {
    vec4 to = light.parallel ? vec4(-light.axis, FAR) : vec4(light.position - x, 1.0);
    float radius = max(light.parallel ? 0.0 : light.radius, u_softness * length(to.xyz));
    if (u_sample > 0 && radius > 0.0) to.xyz += radius * noise_in_ball();
    return to;
}

// Share of the intensity that arrives along unit -l: falloff and the spot's cone
float share(Light light, vec3 l, float distance) {
    float result = light.fades ? 1.0 / (distance * distance) : 1.0;
    if (light.outer < FAR) {
        float angle = atan(length(cross(l, light.axis)), -dot(l, light.axis));   // acos is off by 1e-4 on some drivers
        if (angle > light.outer) return 0.0;
        if (angle > light.inner) {
            float s = (light.outer - angle) / (light.outer - light.inner);
            result *= s * s * (3.0 - 2.0 * s);
        }
    }
    return result;
}

float highlight(Material m, vec3 l, vec3 eye, vec3 n) {
    vec3 half_way = m.half_vector ? normalized(l + eye) : 2.0 * dot(n, l) * n - l;
    float cosine = dot(half_way, m.half_vector ? n : eye);
    return cosine > 0.0 ? pow(cosine, m.shininess) : 0.0;
}

// The ray to a light and what its light would do at x; share 0 if nothing
struct Arrival {
    vec3 l;
    float end, cosine, shine, share;
};

const float FAINT_SHINE = 1e-5;   // a highlight under this is not worth a shadow ray

Arrival light_at(Light light, Material m, vec3 x, vec3 n, vec3 eye) {
    vec4 to = towards(light, x);
    float distance = length(to.xyz);
    if (distance == 0.0) return Arrival(to.xyz, to.w, 0.0, 0.0, 0.0);
    vec3 l = to.xyz / distance;
    float cosine = dot(n, l);
    if (cosine <= 0.0) return Arrival(to.xyz, to.w, cosine, 0.0, 0.0);
    float shine = m.specular.r + m.specular.g + m.specular.b > 0.0 ? highlight(m, l, eye, n) : 0.0;
    float part = m.diffuse == 0.0 && shine < FAINT_SHINE ? 0.0 : share(light, l, distance);
    return Arrival(to.xyz, to.w, cosine, shine, part);
}
